// Time steps, one after the other.

"use strict";

const steps = (() => {
  let playing = false;
  let waiting = null;
  const go = (number) => {
    if (!field || field.steps.length < 2) return;
    difference.leave();
    const count = field.steps.length;
    waiting = ((number % count) + count) % count;
    link.command({ do: "step", number: waiting });
  };
  function set(next) {
    if (!field || field.steps.length < 2) return;
    playing = next;
    $("play").setAttribute("aria-pressed", String(playing));
    $("play").textContent = playing ? "❚❚" : "▶";
    if (playing) go((state?.step ?? 0) + 1);
  }
  return {
    go, set,
    toggle: () => set(!playing),
    stop: () => { if (playing) set(false); },
    shown: (header) => {
      if (!playing || !state || state.step !== waiting || header.version < state.version) return;
      waiting = null;
      setTimeout(() => { if (playing) go(state.step + 1); }, 120);
    },
  };
})();
