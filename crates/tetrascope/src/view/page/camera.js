// Turning, moving and zooming, and where points of the volume are on the page.

"use strict";

const camera = (() => {
  const canvas = picture.canvas;
  const add = (a, b, s = 1) => a.map((x, i) => x + s * b[i]);
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const scale = (a, s) => a.map((x) => x * s);
  const unit = (a) => scale(a, 1 / Math.hypot(...a));
  /** `v` turned about the unit vector `axis` (Rodrigues). */
  function turned(v, axis, angle) {
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    return add(add(scale(v, c), cross(axis, v), s), axis, dot(axis, v) * (1 - c));
  }

  let now = null;
  let held = 0;
  let timer = null;

  function axes() {
    const forward = unit(add(now.focal_point, now.position, -1));
    const right = unit(cross(forward, now.view_up));
    return { forward, right, up: cross(right, forward) };
  }

  function turn(right, down, roll = 0) {
    const { forward, right: axis, up } = axes();
    let back = add(now.position, now.focal_point, -1);
    back = turned(back, up, -right);
    const side = turned(axis, up, -right);
    back = turned(back, side, -down);
    const raised = turned(up, side, -down);
    now.position = add(now.focal_point, back);
    now.view_up = turned(raised, forward, roll);
  }

  /** Moves by parts of the picture's height. */
  function move(right, up) {
    const { right: x, up: y } = axes();
    const distance = Math.hypot(...add(now.position, now.focal_point, -1));
    const half = now.parallel_scale ?? distance * Math.tan((now.view_angle * Math.PI) / 360);
    const by = add(scale(x, -2 * half * right), y, -2 * half * up);
    now.position = add(now.position, by);
    now.focal_point = add(now.focal_point, by);
  }

  function zoom(factor) {
    const back = add(now.position, now.focal_point, -1);
    if (now.parallel_scale) now.parallel_scale /= factor;
    now.position = add(now.focal_point, scale(back, 1 / factor));
  }

  const asked = () => ({ do: "camera", camera: now });
  function tell() {
    link.drag(asked());
    clip.place();
  }

  // The picture's middle and half its height on the page, pixels: the canvas may be wider or taller.
  function frame() {
    const box = canvas.getBoundingClientRect();
    const half = Math.min(box.height, (box.width * canvas.height) / canvas.width) / 2;
    return { x: box.left + box.width / 2, y: box.top + box.height / 2, half };
  }

  /** Half the picture's height in world units, at a distance before the eye. */
  const extent = (distance) => now.parallel_scale ?? distance * Math.tan((now.view_angle * Math.PI) / 360);

  /** The place of a point on the page, pixels; null behind the eye. */
  function project(point) {
    const { forward, right, up } = axes();
    const from = add(point, now.position, -1);
    const distance = dot(from, forward);
    if (!now.parallel_scale && distance <= 0) return null;
    const { x, y, half } = frame();
    const scale = half / extent(distance);
    return [x + dot(from, right) * scale, y - dot(from, up) * scale];
  }

  /** The ray through a place of the page: where it begins, and its direction. */
  function ray([px, py]) {
    const { forward, right, up } = axes();
    const { x, y, half } = frame();
    const side = add(scale(right, (px - x) / half), up, (y - py) / half);
    const isParallel = now.parallel_scale !== undefined;
    return isParallel
      ? { origin: add(now.position, side, now.parallel_scale), direction: forward }
      : { origin: now.position, direction: unit(add(forward, side, extent(1))) };
  }

  /** Says that the hand rests, once it does. */
  function rest(after = 0) {
    clearTimeout(timer);
    timer = setTimeout(() => {
      if (held === 0) {
        timer = null;
        link.command(asked());
      }
    }, after);
  }

  // Pointers: one turns, with Shift, the right or the middle button it moves; two pinch.
  const fingers = new Map();
  canvas.addEventListener("pointerdown", (event) => {
    if (!now) return;
    difference.leave();
    canvas.setPointerCapture(event.pointerId);
    canvas.classList.add("grabbed");
    fingers.set(event.pointerId, [event.clientX, event.clientY]);
    held = fingers.size;
    picture.tellSize(true);
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = fingers.get(event.pointerId);
    if (!before || !now) return;
    const height = canvas.clientHeight;
    const [dx, dy] = [event.clientX - before[0], event.clientY - before[1]];
    if (fingers.size === 1) {
      if (event.shiftKey || event.buttons & 6) move(dx / height, -dy / height);
      else turn((dx / height) * Math.PI, (dy / height) * Math.PI);
      fingers.set(event.pointerId, [event.clientX, event.clientY]);
    } else {
      const spread = () => {
        const [a, b] = [...fingers.values()];
        return { size: Math.hypot(a[0] - b[0], a[1] - b[1]), middle: [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2], angle: Math.atan2(b[1] - a[1], b[0] - a[0]) };
      };
      const from = spread();
      fingers.set(event.pointerId, [event.clientX, event.clientY]);
      const to = spread();
      if (from.size > 4 && to.size > 4) zoom(clamp(to.size / from.size, 0.5, 2));
      move((to.middle[0] - from.middle[0]) / height, -(to.middle[1] - from.middle[1]) / height);
      let roll = to.angle - from.angle;
      if (Math.abs(roll) < 0.5) turn(0, 0, -roll);
    }
    tell();
  });
  function up(event) {
    if (!fingers.delete(event.pointerId)) return;
    held = fingers.size;
    if (held === 0) {
      canvas.classList.remove("grabbed");
      rest();
    }
  }
  canvas.addEventListener("pointerup", up);
  canvas.addEventListener("pointercancel", up);
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    if (!now) return;
    difference.leave();
    const lines = event.deltaMode === 1 ? event.deltaY * 16 : event.deltaY;
    zoom(Math.exp(-clamp(lines, -200, 200) * 0.002));
    tell();
    rest(180);
  }, { passive: false });

  const step = Math.PI / 36;
  const keys = {
    ArrowLeft: () => turn(-step, 0), ArrowRight: () => turn(step, 0),
    ArrowUp: () => turn(0, -step), ArrowDown: () => turn(0, step),
    "+": () => zoom(1.1), "=": () => zoom(1.1), "-": () => zoom(1 / 1.1), _: () => zoom(1 / 1.1),
    ",": () => turn(0, 0, step), ".": () => turn(0, 0, -step),
  };
  const moves = {
    ArrowLeft: () => move(-0.04, 0), ArrowRight: () => move(0.04, 0),
    ArrowUp: () => move(0, 0.04), ArrowDown: () => move(0, -0.04),
  };
  canvas.addEventListener("keydown", (event) => {
    const act = (event.shiftKey && moves[event.key]) || keys[event.key];
    if (!act || !now || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    difference.leave();
    act();
    tell();
    rest(250);
  });

  return {
    take: (given) => {
      now = structuredClone(given);
      clip.place();
    },
    isHeld: () => held > 0 || timer !== null,
    fit: (from) => { difference.leave(); link.command({ do: "fit", from }); },
    now: () => now,
    project, ray,
  };
})();
