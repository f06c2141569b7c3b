// Clip planes along the axes: sliders beside the picture, and handles in it.

"use strict";

const clip = (() => {
  const AXES = ["x", "y", "z"];
  const words = (axis, end) => `${end ? "greatest" : "least"} ${AXES[axis]} that stays`;

  // Two planes for each axis, at parts of the volume's box; others come from scene files.
  const along = (plane) => {
    const size = Math.hypot(...plane.normal);
    const axis = plane.normal.findIndex((n) => Math.abs(Math.abs(n) - size) < 1e-12 * size);
    return axis < 0 ? null : { axis, sign: Math.sign(plane.normal[axis]), at: plane.point[axis] };
  };

  function read() {
    const [low, high] = field.bounds;
    const parts = [0, 1, 2].map((axis) => [low[axis], high[axis]]);
    const others = [];
    for (const plane of state.clip) {
      const found = along(plane);
      if (!found) others.push(plane);
      else if (found.sign > 0) parts[found.axis][0] = Math.max(parts[found.axis][0], found.at);
      else parts[found.axis][1] = Math.min(parts[found.axis][1], found.at);
    }
    return { parts, others };
  }

  function command(parts, others) {
    const [low, high] = field.bounds;
    const planes = [...others];
    parts.forEach(([from, to], axis) => {
      const plane = (at, sign) => {
        const [point, normal] = [[...low], [0, 0, 0]];
        point[axis] = at;
        normal[axis] = sign;
        planes.push({ point, normal });
      };
      if (from > low[axis]) plane(from, 1);
      if (to < high[axis]) plane(to, -1);
    });
    return { do: "clip", planes };
  }

  function sliders() {
    const { parts, others } = read();
    $("clip-others").textContent = others.length ? `${others.length} oblique ${others.length === 1 ? "plane" : "planes"} of a scene` : "";
    if ($("clip-list").contains(document.activeElement) && document.activeElement.type === "range") return;
    const [low, high] = field.bounds;
    $("clip-list").replaceChildren(...AXES.map((name, axis) => {
      const span = high[axis] - low[axis] || 1;
      const slider = (end) => {
        const value = (parts[axis][end] - low[axis]) / span;
        const set = (event, moving) => put(axis, end, low[axis] + span * event.target.valueAsNumber, moving);
        return make("input", { type: "range", min: 0, max: 1, step: 0.002, value, "aria-label": words(axis, end), oninput: (event) => set(event, true), onchange: (event) => set(event, false) });
      };
      return make("div", { class: "clip" }, make("span", {}, name), slider(0), slider(1));
    }));
  }

  /** Moves a plane to a coordinate, not past the other one of its axis. */
  function put(axis, end, at, moving) {
    const { parts, others } = read();
    const pair = parts[axis];
    const [low, high] = field.bounds;
    at = clamp(at, low[axis], high[axis]);
    pair[end] = end ? Math.max(at, pair[0]) : Math.min(at, pair[1]);
    const next = command(parts, others);
    state.clip = next.planes;
    if (moving) link.drag(next);
    else link.command(next);
    place();
  }

  // ---- handles in the picture: each lies in the middle of its plane, as far as others leave it

  let dragged = null; // { axis, end, off }: how far the pointer took hold from the handle's coordinate
  const handles = AXES.flatMap((_, axis) => [0, 1].map((end) => {
    const handle = make("div", { class: `handle of-${AXES[axis]}`, role: "slider", tabindex: 0, "aria-label": words(axis, end), "aria-orientation": "horizontal" });
    handle.addEventListener("pointerdown", (event) => {
      event.preventDefault();
      handle.focus();
      handle.setPointerCapture(event.pointerId);
      difference.leave();
      const at = coordinate(axis, [event.clientX, event.clientY]);
      if (at !== null) dragged = { axis, end, off: read().parts[axis][end] - at };
    });
    handle.addEventListener("pointermove", (event) => {
      if (dragged?.axis !== axis || dragged.end !== end) return;
      const at = coordinate(axis, [event.clientX, event.clientY]);
      if (at !== null) put(axis, end, at + dragged.off, true);
    });
    const release = () => {
      if (dragged) put(axis, end, read().parts[axis][end], false);
      dragged = null;
    };
    handle.addEventListener("pointerup", release);
    handle.addEventListener("pointercancel", release);
    handle.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      const [low, high] = [field.bounds[0][axis], field.bounds[1][axis]];
      const at = read().parts[axis][end];
      const step = (high - low) / (event.shiftKey ? 10 : 100);
      const next = { ArrowLeft: at - step, ArrowDown: at - step, ArrowRight: at + step, ArrowUp: at + step, Home: low, End: high }[event.key];
      if (next === undefined) return;
      event.preventDefault();
      event.stopPropagation();
      difference.leave();
      put(axis, end, next, false);
    });
    return { axis, end, handle };
  }));
  $("handles").append(...handles.map(({ handle }) => handle));

  /** The middle of the box that stays, with one coordinate set. */
  function middle(parts, axis, at) {
    const point = parts.map(([from, to]) => (from + to) / 2);
    point[axis] = at;
    return point;
  }

  /** The coordinate along an axis, through the middle of what stays, that is nearest to a place of the page. */
  function coordinate(axis, place) {
    const { origin, direction } = camera.ray(place);
    const base = middle(read().parts, axis, 0);
    // The nearest points of two lines: s along the axis is (d·w a − w) / (1 − a²) with a = d[axis], w from the
    // ray's origin to the base. Where both nearly coincide, a place says nothing of the coordinate.
    const w = base.map((x, i) => x - origin[i]);
    const a = direction[axis];
    const room = 1 - a * a;
    if (room < 1e-4) return null;
    const along = w.reduce((sum, x, i) => sum + x * direction[i], 0);
    return (along * a - w[axis]) / room;
  }

  function place() {
    const isOn = field && state && camera.now() && $("clip-handles").getAttribute("aria-pressed") === "true";
    $("handles").hidden = !isOn;
    if (!isOn) return;
    const { parts } = read();
    const stage = $("stage").getBoundingClientRect();
    for (const { axis, end, handle } of handles) {
      const at = parts[axis][end];
      const [low, high] = [field.bounds[0][axis], field.bounds[1][axis]];
      const shown = high > low ? camera.project(middle(parts, axis, at)) : null;
      handle.hidden = shown === null;
      if (shown === null) continue;
      handle.style.left = `${shown[0] - stage.left}px`;
      handle.style.top = `${shown[1] - stage.top}px`;
      handle.setAttribute("aria-valuemin", low);
      handle.setAttribute("aria-valuemax", high);
      handle.setAttribute("aria-valuenow", at);
      handle.setAttribute("aria-valuetext", `${AXES[axis]} = ${short(at)}`);
      handle.title = `${words(axis, end)}: ${short(at)}`;
    }
  }

  $("clip-none").onclick = () => link.command({ do: "clip", planes: [] });
  $("clip-handles").onclick = () => {
    const isOn = $("clip-handles").getAttribute("aria-pressed") !== "true";
    $("clip-handles").setAttribute("aria-pressed", String(isOn));
    place();
  };
  new ResizeObserver(place).observe($("stage"));

  return {
    place,
    state: () => {
      if (dragged) return;
      sliders();
      place();
    },
  };
})();
