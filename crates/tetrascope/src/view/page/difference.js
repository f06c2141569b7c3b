// The difference to the truth.

"use strict";

const difference = (() => {
  let on = false;
  let shows = false;

  function set(next) {
    if (on === next) return;
    on = next;
    $("difference").setAttribute("aria-pressed", String(on));
    link.send({ difference: on });
    if (on) knowledge.working("drawing the truth", 0);
    else {
      knowledge.working(null);
      if (shows) again();
      shows = false;
      $("legend").hidden = true;
    }
  }

  /** Asks for the picture as it was. */
  function again() {
    if (state) link.command({ do: "camera", camera: camera.now() });
  }

  function shown(header) {
    shows = header.kind === "difference";
    $("legend").hidden = !shows;
    if (!shows) return;
    knowledge.working(null);
    const { rmse, greatest, decades, truth_bound } = header.more;
    $("legend-high").textContent = short(greatest);
    $("legend-low").textContent = greatest > 0 ? short(greatest / 10 ** decades) : "0";
    $("legend-text").textContent = `RMSE ${short(rmse)}, greatest ${short(greatest)}; the truth is known to ${short(truth_bound)}. Of linear premultiplied RGBA, 1 is white.`;
  }

  return {
    isOn: () => on,
    shows: () => shows,
    toggle: () => set(!on),
    leave: () => { if (on) { shows = false; set(false); $("legend").hidden = true; } },
    off: () => set(false),
    shown,
  };
})();
