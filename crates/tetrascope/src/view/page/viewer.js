// The viewer's page: shows pictures that the server draws, and tells it what hands do.
//
// 1. `link`: the WebSocket, what it brings and what it takes; lost, it is opened again.
// 2. `picture`: pictures onto the screen, and how long they took.
// 3. `camera`: turning, moving and zooming.
// 4. `editor`: colors and opacities over the histogram.
// 5. `panels`: everything else that can be chosen, and what is told of the picture.

"use strict";

const $ = (id) => document.getElementById(id);
const clamp = (x, low, high) => Math.min(Math.max(x, low), high);

/** A number as people read it: four significant digits, powers of ten where there are many. */
function short(x) {
  if (x === null || x === undefined) return "–";
  if (x === 0) return "0";
  const size = Math.abs(x);
  if (!Number.isFinite(x)) return String(x);
  if (size >= 1e5 || size < 1e-3) return x.toExponential(2).replace("e+", "e");
  return String(Number(x.toPrecision(4)));
}

/** All digits that tell a number apart, for inputs. */
const exact = (x) => String(Number(x.toPrecision(12)));

function bytes(n) {
  const units = ["B", "kB", "MB", "GB", "TB"];
  let i = 0;
  while (n >= 1000 && i < 4) { n /= 1000; i += 1; }
  return `${n < 10 && i > 0 ? n.toFixed(1) : Math.round(n)} ${units[i]}`;
}

const milliseconds = (ms) => (ms < 10 ? `${ms.toFixed(1)} ms` : ms < 1e4 ? `${Math.round(ms)} ms` : `${(ms / 1000).toFixed(1)} s`);

/** An element with attributes, listeners (`onclick`) and children. */
function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) element.addEventListener(key.slice(2), value);
    else if (value !== null && value !== undefined) element.setAttribute(key, value);
  }
  element.append(...children);
  return element;
}

function say(text, help = null, isProblem = false) {
  const box = make("div", { class: isProblem ? "message problem" : "message" },
    make("div", {}, text, ...(help ? [make("div", { class: "hint" }, help)] : [])),
    make("button", { type: "button", "aria-label": "Dismiss", onclick: () => box.remove() }, "×"));
  $("messages").append(box);
  while ($("messages").children.length > 3) $("messages").firstChild.remove();
  setTimeout(() => box.remove(), isProblem ? 12000 : 6000);
}

// What the server has told, as it came last.
let hello = null;
let field = null;
let state = null;
let estimate = null;

// ---------------------------------------------------------------- link

const link = (() => {
  let socket = null;
  let seq = 0;
  let tries = 0;
  let timer = null;
  const sentAt = new Map();
  const pending = new Map(); // the newest command of each kind, until the next screen
  let scheduled = false;

  function open() {
    clearTimeout(timer);
    const url = new URL("ws", location.href.split("#")[0]);
    url.protocol = url.protocol === "https:" ? "wss:" : "ws:";
    const mine = new WebSocket(url);
    socket = mine;
    mine.binaryType = "arraybuffer";
    mine.onmessage = (event) => {
      if (mine !== socket) return;
      if (typeof event.data === "string") take(JSON.parse(event.data));
      else picture.take(event.data);
    };
    mine.onclose = (event) => {
      if (mine === socket) lost(event);
    };
  }

  function lost(event) {
    socket = null;
    picture.forget();
    // Refused in words: trying again at once does no good.
    const words = event.reason;
    const wait = Math.min(500 * 2 ** tries, 8000);
    tries += 1;
    if (words || tries > 1) {
      $("gone").hidden = false;
      $("gone-text").textContent = words
        ? `It says: ${words}.`
        : "It may have ended, or the tunnel to it is closed. This page tries again by itself; the view is kept.";
    }
    $("status-link").textContent = "not connected";
    timer = setTimeout(async () => {
      // A server that is there and knows the address no more says so.
      try {
        const answer = await fetch("icon.svg", { cache: "no-store" });
        if (answer.status === 403) {
          $("gone").hidden = false;
          $("gone-text").textContent = "Another viewer answers here: " + (await answer.text());
        }
      } catch { /* Nobody is there. */ }
      open();
    }, wait);
  }

  function take(message) {
    switch (message.type) {
      case "hello":
        tries = 0;
        $("gone").hidden = true;
        $("status-link").textContent = "";
        if (hello && hello.run !== message.run) restoring = undefined;
        hello = message;
        panels.catalog();
        break;
      case "field":
        field = message;
        panels.field();
        editor.field();
        break;
      case "state":
        takeState(message);
        break;
      case "camera":
        if (message.by !== hello.client) camera.take(message.camera);
        break;
      case "estimate":
        estimate = message.estimate;
        panels.honesty();
        break;
      case "histogram":
        editor.histogram(message);
        break;
      case "progress":
        panels.progress(message);
        break;
      case "problem":
        say(message.message, message.help, true);
        if (message.state) takeState(message.state);
        panels.working(null);
        steps.stop();
        break;
      case "note":
        say(message.message);
        break;
    }
  }

  function takeState(message) {
    const isFirst = state === null || restoring === undefined;
    state = message;
    if (!camera.isHeld()) camera.take(message.camera);
    panels.state();
    editor.state();
    if (isFirst) restore();
    keep();
  }

  // A link's view, or that of a server which has started anew.
  let restoring;
  function restore() {
    restoring = null;
    let saved = null;
    if (location.hash.length > 1) {
      try {
        saved = JSON.parse(new TextDecoder().decode(fromBase64(location.hash.slice(1))));
      } catch {
        say("The view in this address is damaged and passed over.", null, true);
      }
      history.replaceState(null, "", location.href.split("#")[0]);
    } else {
      const kept = JSON.parse(sessionStorage.getItem("view") ?? "null");
      if (kept && kept.run !== hello.run && kept.name === field.name) saved = kept.saved;
    }
    if (saved) command({ do: "restore", saved });
    picture.tellSize(hello.is_first || saved !== null);
  }

  function keep() {
    const kept = { run: hello.run, name: field.name, saved: state.saved };
    sessionStorage.setItem("view", JSON.stringify(kept));
  }

  function send(message) {
    if (!socket || socket.readyState !== WebSocket.OPEN) return 0;
    seq += 1;
    sentAt.set(seq, performance.now());
    if (sentAt.size > 500) sentAt.delete(sentAt.keys().next().value);
    socket.send(JSON.stringify({ seq, ...message }));
    return seq;
  }

  /** A change, at once. */
  const command = (command, moving = false) => {
    pending.delete(command.do);
    return send({ command, moving });
  };

  /** A change while a hand moves: the newest of its kind, with the next screen. */
  function drag(command) {
    pending.set(command.do, command);
    if (scheduled) return;
    scheduled = true;
    requestAnimationFrame(() => {
      scheduled = false;
      for (const command of pending.values()) send({ command, moving: true });
      pending.clear();
    });
  }

  return {
    open, send, command, drag,
    shown: (id) => socket?.readyState === WebSocket.OPEN && socket.send(`{"shown":${id}}`),
    since: (of) => (sentAt.has(of) ? performance.now() - sentAt.get(of) : null),
    retry: () => { tries = 0; open(); },
  };
})();

const toBase64 = (bytes) => btoa(String.fromCharCode(...bytes)).replace(/\+/g, "-").replace(/\//g, "_").replace(/=+$/, "");
const fromBase64 = (text) => Uint8Array.from(atob(text.replace(/-/g, "+").replace(/_/g, "/")), (c) => c.charCodeAt(0));

// ---------------------------------------------------------------- picture

const picture = (() => {
  const canvas = $("picture");
  const context = canvas.getContext("2d");
  let header = null; // of the picture that is shown
  const latencies = [];
  const arrivals = [];
  let told = null;
  let last = null; // the header of the last moving picture

  async function take(buffer) {
    const length = new DataView(buffer).getUint32(0, true);
    const next = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
    const png = new Blob([new Uint8Array(buffer, 4 + length)], { type: "image/png" });
    next.bytes = png.size;
    let image;
    try {
      image = await createImageBitmap(png, { colorSpaceConversion: "none" });
    } catch {
      link.shown(next.id);
      return;
    }
    // A difference that is not wanted any more, and a picture of a view that was left.
    const isStale = next.kind === "difference" ? !difference.isOn() || next.version !== state?.version : difference.shows() && next.version === header?.version;
    if (!isStale) show(next, image);
    image.close();
    link.shown(next.id);
  }

  function show(next, image) {
    const [width, height] = next.full;
    if (canvas.width !== width || canvas.height !== height) {
      canvas.width = width;
      canvas.height = height;
    }
    // The old picture stays until the new one is complete: both happen between two screens.
    context.clearRect(0, 0, width, height);
    context.imageSmoothingEnabled = next.size[0] !== width;
    context.imageSmoothingQuality = "medium";
    context.drawImage(image, 0, 0, width, height);
    header = next;
    const now = performance.now();
    if (next.client === hello?.client && next.seq > 0 && next.kind !== "difference") {
      const latency = link.since(next.seq);
      if (latency !== null && next.kind !== "refining") {
        // A picture that was refined while nothing moved says nothing of latency.
        if (next.kind === "quick" || last?.seq !== next.seq) {
          latencies.push(latency);
          if (latencies.length > 40) latencies.shift();
        }
      }
    }
    if (next.kind === "quick" || (next.kind === "complete" && next.more.why)) {
      last = next;
      arrivals.push(now);
      while (arrivals.length && now - arrivals[0] > 2000) arrivals.shift();
    }
    canvas.dataset.kind = next.kind;
    canvas.dataset.version = next.version;
    canvas.setAttribute("aria-label", `Picture of ${field?.name ?? "the volume"}, ${next.kind}, by ${next.algorithm}`);
    panels.shown(next);
    difference.shown(next);
    steps.shown(next);
  }

  function size() {
    const box = $("stage").getBoundingClientRect();
    const scale = window.devicePixelRatio || 1;
    let [width, height] = [box.width, box.height].map((side) => Math.max(16, Math.round(side * scale)));
    const most = Math.sqrt(Math.min(1, 8e6 / (width * height)));
    return [Math.floor(width * most), Math.floor(height * most)];
  }

  /** Tells the size of this page's picture; where others look too, only with the first input. */
  function tellSize(isMine) {
    const [width, height] = size();
    told = `${width}x${height}`;
    if (isMine && state && (state.size[0] !== width || state.size[1] !== height)) link.command({ do: "size", width, height });
  }

  let timer = null;
  new ResizeObserver(() => {
    clearTimeout(timer);
    timer = setTimeout(() => {
      if (state && told !== size().join("x")) tellSize(true);
    }, 150);
  }).observe($("stage"));

  return {
    take, tellSize, size,
    forget: () => { arrivals.length = 0; },
    header: () => header,
    moving: () => last,
    /** The middle of the last latencies, ms; null without one. */
    latency: () => (latencies.length ? [...latencies].sort((a, b) => a - b)[latencies.length >> 1] : null),
    latencies,
    rate: () => (arrivals.length > 3 ? (1000 * (arrivals.length - 1)) / (arrivals.at(-1) - arrivals[0]) : null),
    canvas,
  };
})();

// ---------------------------------------------------------------- camera

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
    take: (given) => { now = structuredClone(given); },
    isHeld: () => held > 0 || timer !== null,
    fit: (from) => { difference.leave(); link.command({ do: "fit", from }); },
    now: () => now,
  };
})();

// ---------------------------------------------------------------- difference

const difference = (() => {
  let on = false;
  let shows = false;

  function set(next) {
    if (on === next) return;
    on = next;
    $("difference").setAttribute("aria-pressed", String(on));
    link.send({ difference: on });
    if (on) panels.working("drawing the truth", 0);
    else {
      panels.working(null);
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
    panels.working(null);
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

// ---------------------------------------------------------------- time steps

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

// ---------------------------------------------------------------- editor

const editor = (() => {
  const graph = $("editor");
  const band = $("colors");
  let preset = null;
  let axis = [0, 1];
  let counts = null; // of the histogram, with the axis that it is of
  let chosen = null; // { kind: "opacity" | "color" | "surface", index }
  let dragging = false;
  let surfaces = [];
  const isSurfaces = () => state?.model === "isosurfaces";
  const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const hex = (color) => "#" + color.map((c) => Math.round(255 * clamp(c, 0, 1)).toString(16).padStart(2, "0")).join("");
  const unhex = (text) => [1, 3, 5].map((i) => parseInt(text.slice(i, i + 2), 16) / 255);

  /** Opacity between two points at `s`, as VTK has it with midpoint and sharpness. */
  function between(a, b, s) {
    const middle = clamp(a.midpoint, 1e-5, 1 - 1e-5);
    s = s < middle ? (0.5 * s) / middle : 0.5 + (0.5 * (s - middle)) / (1 - middle);
    if (a.sharpness > 0.99) return s < 0.5 ? a.opacity : b.opacity;
    if (a.sharpness < 0.01) return a.opacity * (1 - s) + b.opacity * s;
    const power = 1 + 10 * a.sharpness;
    s = s < 0.5 ? 0.5 * (2 * s) ** power : 1 - 0.5 * (2 * (1 - s)) ** power;
    const slope = (1 - a.sharpness) * (b.opacity - a.opacity);
    const value = (2 * s ** 3 - 3 * s ** 2 + 1) * a.opacity + (3 * s ** 2 - 2 * s ** 3) * b.opacity + (2 * s ** 3 - 3 * s ** 2 + s) * slope;
    return clamp(value, Math.min(a.opacity, b.opacity), Math.max(a.opacity, b.opacity));
  }

  function opacityAt(x) {
    const points = preset.opacities;
    let i = 0;
    while (i < points.length && points[i].scalar <= x) i += 1;
    if (i === 0) return points[0].opacity;
    if (i === points.length) return points.at(-1).opacity;
    const [a, b] = [points[i - 1], points[i]];
    return between(a, b, (x - a.scalar) / (b.scalar - a.scalar));
  }

  /** The color at a value, mixed in sRGB: the picture itself is mixed by the server. */
  function colorAt(x) {
    const points = preset.colors;
    let i = 0;
    while (i < points.length && points[i].scalar <= x) i += 1;
    if (i === 0) return points[0].color;
    if (i === points.length) return points.at(-1).color;
    const [a, b] = [points[i - 1], points[i]];
    if (preset.color_space === "Step") return b.color;
    const s = (x - a.scalar) / (b.scalar - a.scalar);
    return a.color.map((c, k) => c * (1 - s) + b.color[k] * s);
  }

  // ---- the axis

  function setAxis(low, high) {
    if (!(high > low)) [low, high] = [low - 0.5 * (Math.abs(low) || 1), high + 0.5 * (Math.abs(high) || 1)];
    axis = [low, high];
    ask();
    draw();
  }

  let timer = null;
  function ask() {
    clearTimeout(timer);
    timer = setTimeout(() => link.send({ histogram: axis }), 60);
  }

  function ends() {
    const scalars = [...preset.colors, ...preset.opacities].map((p) => p.scalar);
    return [Math.min(...scalars), Math.max(...scalars)];
  }

  function zoomRange() {
    const [low, high] = ends();
    const pad = 0.04 * (high - low);
    setAxis(low - pad, high + pad);
  }

  function zoomAll() {
    const [low, high] = field.range ?? ends();
    const pad = 0.02 * (high - low);
    setAxis(low - pad, high + pad);
  }

  // ---- drawing

  const inset = 8;
  const toX = (scalar, width) => inset + ((scalar - axis[0]) / (axis[1] - axis[0])) * (width - 2 * inset);
  const toScalar = (x, width) => axis[0] + ((x - inset) / (width - 2 * inset)) * (axis[1] - axis[0]);
  const toY = (opacity, height) => height - inset - opacity * (height - 2 * inset);
  const toOpacity = (y, height) => clamp((height - inset - y) / (height - 2 * inset), 0, 1);

  function context(canvas) {
    const scale = window.devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (canvas.width !== Math.round(width * scale)) canvas.width = Math.round(width * scale);
    if (canvas.height !== Math.round(height * scale)) canvas.height = Math.round(height * scale);
    const c = canvas.getContext("2d");
    c.setTransform(scale, 0, 0, scale, 0, 0);
    c.clearRect(0, 0, width, height);
    return [c, width, height];
  }

  function draw() {
    if (!preset || graph.clientWidth === 0) return;
    const [c, width, height] = context(graph);
    if (counts) {
      const isLog = $("log").checked;
      const level = (n) => (isLog ? Math.log1p(n) : n);
      const most = level(Math.max(...counts.counts)) || 1;
      c.fillStyle = css("--bar");
      c.globalAlpha = 0.75;
      const step = (counts.high - counts.low) / counts.counts.length;
      counts.counts.forEach((n, i) => {
        if (n === 0) return;
        const from = toX(counts.low + i * step, width);
        const to = toX(counts.low + (i + 1) * step, width);
        const tall = Math.max(1, (level(n) / most) * (height - 2 * inset));
        c.fillRect(from, height - inset - tall, Math.max(to - from, 0.6), tall);
      });
      c.globalAlpha = 1;
    }
    // What is under the curve has its color.
    const edge = [];
    for (let x = 0; x <= width; x += 1) {
      const scalar = toScalar(x, width);
      const y = toY(opacityAt(scalar), height);
      edge.push([x, y]);
      if (!isSurfaces()) {
        c.fillStyle = hex(colorAt(scalar));
        c.globalAlpha = 0.45;
        c.fillRect(x, y, 1, height - inset - y);
      }
    }
    c.globalAlpha = isSurfaces() ? 0.35 : 1;
    c.strokeStyle = css("--text");
    c.lineWidth = 1.5;
    c.beginPath();
    edge.forEach(([x, y], i) => (i ? c.lineTo(x, y) : c.moveTo(x, y)));
    c.stroke();
    if (!isSurfaces()) {
      preset.opacities.forEach((point, index) => {
        dot(c, toX(point.scalar, width), toY(point.opacity, height), isChosen("opacity", index), css("--panel"));
      });
    }
    c.globalAlpha = 1;
    surfaces.forEach((surface, index) => {
      if (!isSurfaces()) return;
      const x = toX(surface.value, width);
      c.strokeStyle = isChosen("surface", index) ? css("--accent") : css("--text");
      c.lineWidth = isChosen("surface", index) ? 3 : 2;
      c.beginPath();
      c.moveTo(x, inset);
      c.lineTo(x, height - inset);
      c.stroke();
      dot(c, x, inset + 4, isChosen("surface", index), hex(shownColor(index)));
    });
    drawColors();
    $("axis-low").textContent = short(axis[0]);
    $("axis-middle").textContent = short((axis[0] + axis[1]) / 2);
    $("axis-high").textContent = short(axis[1]);
  }

  /** A surface's color in sRGB, as the picture has it. */
  function shownColor(index) {
    const linear = state.isosurfaces[index]?.color ?? [1, 1, 1];
    return linear.map((c) => (c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055));
  }

  function drawColors() {
    const [c, width, height] = context(band);
    for (let x = 0; x < width; x += 1) {
      c.fillStyle = hex(colorAt(toScalar(x, width)));
      c.fillRect(x, 0, 1, height);
    }
    if (state.look.colormap) return;
    preset.colors.forEach((point, index) => {
      dot(c, toX(point.scalar, width), height / 2, isChosen("color", index), hex(point.color));
    });
  }

  function dot(c, x, y, isOn, fill) {
    c.beginPath();
    c.arc(x, y, isOn ? 7 : 5, 0, 2 * Math.PI);
    c.fillStyle = fill;
    c.fill();
    c.lineWidth = isOn ? 3 : 1.5;
    c.strokeStyle = isOn ? css("--accent") : css("--text");
    c.stroke();
  }

  const isChosen = (kind, index) => chosen?.kind === kind && chosen.index === index;

  // ---- editing

  function tell(moving) {
    const command = chosen?.kind === "surface"
      ? { do: "isosurfaces", surfaces }
      : { do: "points", preset: { ...preset, colors: keepsColors() ? [] : preset.colors }, keep_colors: keepsColors() };
    if (moving) link.drag(command);
    else link.command(command);
  }

  // A map with a name keeps it while only opacities are edited.
  const keepsColors = () => Boolean(state.look.colormap) && chosen?.kind !== "color";

  const list = () => ({ opacity: preset.opacities, color: preset.colors, surface: surfaces })[chosen.kind];
  const place = (kind, item) => (kind === "surface" ? item.value : item.scalar);

  function choose(next) {
    chosen = next;
    pointPanel();
    draw();
  }

  function pointPanel() {
    const item = chosen && list()[chosen.index];
    const set = (id, value) => { if (document.activeElement !== $(id)) $(id).value = value; };
    for (const element of document.querySelectorAll(".of-opacity")) element.hidden = chosen?.kind !== "opacity";
    for (const element of document.querySelectorAll(".of-color")) element.hidden = !chosen || chosen.kind === "opacity";
    for (const id of ["point-scalar", "point-remove"]) $(id).disabled = !item;
    if (!item) {
      $("point-text").textContent = "No point is chosen";
      $("point-scalar").value = "";
      return;
    }
    const kind = { opacity: "Opacity point", color: "Color point", surface: "Isosurface" }[chosen.kind];
    $("point-text").textContent = `${kind} ${chosen.index + 1} of ${list().length}`;
    set("point-scalar", exact(place(chosen.kind, item)));
    if (chosen.kind === "opacity") {
      set("point-opacity", exact(item.opacity));
      set("point-midpoint", exact(item.midpoint));
      set("point-sharpness", exact(item.sharpness));
    } else {
      set("point-color", hex(chosen.kind === "color" ? item.color : shownColor(chosen.index)));
    }
  }

  /** Moves the chosen point, not past its neighbors. */
  function moveTo(scalar, opacity) {
    const items = list();
    const item = items[chosen.index];
    if (chosen.kind === "surface") {
      item.value = scalar;
      return;
    }
    const [before, after] = [items[chosen.index - 1], items[chosen.index + 1]];
    item.scalar = clamp(scalar, before?.scalar ?? -Infinity, after?.scalar ?? Infinity);
    if (chosen.kind === "opacity" && opacity !== undefined) item.opacity = opacity;
  }

  function add(kind, scalar, opacity) {
    chosen = { kind, index: 0 };
    const items = list();
    const index = items.findIndex((item) => place(kind, item) > scalar);
    chosen.index = index < 0 ? items.length : index;
    const item = {
      opacity: () => ({ scalar, opacity: opacity ?? opacityAt(scalar), midpoint: 0.5, sharpness: 0 }),
      color: () => ({ scalar, color: colorAt(scalar) }),
      surface: () => ({ value: scalar }),
    }[kind]();
    items.splice(chosen.index, 0, item);
    tell(false);
    choose(chosen);
  }

  function remove() {
    if (!chosen) return;
    const items = list();
    if (items.length < 2) {
      say("The last one stays.");
      return;
    }
    items.splice(chosen.index, 1);
    tell(false);
    choose({ kind: chosen.kind, index: Math.min(chosen.index, items.length - 1) });
  }

  /** Points of a map with a name, few enough to take hold of. */
  function editColors() {
    if (state.look.colormap) {
      const colors = preset.colors;
      const few = 9;
      preset.colors = Array.from({ length: few }, (_, i) => structuredClone(colors[Math.round((i * (colors.length - 1)) / (few - 1))]));
      preset.name = `${state.look.colormap}, edited`;
      chosen = { kind: "color", index: few >> 1 };
      tell(false);
    } else {
      chosen = { kind: "color", index: 0 };
    }
    choose(chosen);
    band.focus();
  }

  const kindOf = (canvas) => (canvas === band ? "color" : isSurfaces() ? "surface" : "opacity");

  function hit(canvas, event) {
    const kind = kindOf(canvas);
    if (kind === "color" && state.look.colormap) return null;
    const items = { opacity: preset.opacities, color: preset.colors, surface: surfaces }[kind];
    let best = null;
    items.forEach((item, index) => {
      const dx = toX(place(kind, item), canvas.clientWidth) - event.offsetX;
      const dy = kind === "opacity" ? toY(item.opacity, canvas.clientHeight) - event.offsetY : 0;
      const far = Math.hypot(dx, dy);
      if (far < 14 && (!best || far < best.far)) best = { kind, index, far };
    });
    return best && { kind: best.kind, index: best.index };
  }

  for (const canvas of [graph, band]) {
    let pan = null;
    canvas.addEventListener("pointerdown", (event) => {
      if (!preset) return;
      canvas.setPointerCapture(event.pointerId);
      if (event.shiftKey || event.button === 1) {
        pan = [event.offsetX, [...axis]];
        return;
      }
      const found = hit(canvas, event);
      if (event.button === 2) {
        if (found) { choose(found); remove(); }
        return;
      }
      if (found) {
        choose(found);
        dragging = true;
      }
    });
    canvas.addEventListener("pointermove", (event) => {
      if (pan) {
        const [x, from] = pan;
        const by = ((event.offsetX - x) / (canvas.clientWidth - 2 * inset)) * (from[1] - from[0]);
        setAxis(from[0] - by, from[1] - by);
      } else if (dragging && chosen && chosen.kind === kindOf(canvas)) {
        moveTo(toScalar(event.offsetX, canvas.clientWidth), toOpacity(event.offsetY, canvas.clientHeight));
        tell(true);
        choose(chosen);
      }
    });
    const end = () => {
      pan = null;
      if (dragging) {
        dragging = false;
        tell(false);
      }
    };
    canvas.addEventListener("pointerup", end);
    canvas.addEventListener("pointercancel", end);
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("dblclick", (event) => {
      const kind = kindOf(canvas);
      if (kind === "color" && state.look.colormap) {
        editColors();
        return;
      }
      add(kind, toScalar(event.offsetX, canvas.clientWidth), kind === "opacity" ? toOpacity(event.offsetY, canvas.clientHeight) : undefined);
    });
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      const at = toScalar(event.offsetX, canvas.clientWidth);
      const factor = Math.exp(clamp(event.deltaY, -200, 200) * 0.002);
      setAxis(at + (axis[0] - at) * factor, at + (axis[1] - at) * factor);
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => {
      const kind = kindOf(canvas);
      if (!preset || event.ctrlKey || event.metaKey || event.altKey) return;
      if (kind === "color" && state.look.colormap) {
        if (event.key === "Enter" || event.key === "Insert") editColors();
        return;
      }
      if (!chosen || chosen.kind !== kind) chosen = { kind, index: 0 };
      const count = list().length;
      const item = list()[chosen.index];
      const step = (axis[1] - axis[0]) / (event.shiftKey ? 20 : 100);
      const act = {
        "[": () => { chosen.index = (chosen.index + count - 1) % count; },
        "]": () => { chosen.index = (chosen.index + 1) % count; },
        ArrowLeft: () => { moveTo(place(kind, item) - step, item?.opacity); tell(false); },
        ArrowRight: () => { moveTo(place(kind, item) + step, item?.opacity); tell(false); },
        ArrowUp: () => { if (kind === "opacity") { moveTo(item.scalar, clamp(item.opacity + 0.02, 0, 1)); tell(false); } },
        ArrowDown: () => { if (kind === "opacity") { moveTo(item.scalar, clamp(item.opacity - 0.02, 0, 1)); tell(false); } },
        Delete: remove,
        Insert: () => {
          const next = list()[chosen.index + 1] ?? list()[chosen.index - 1] ?? item;
          add(kind, ((item ? place(kind, item) : axis[0]) + (next ? place(kind, next) : axis[1])) / 2);
        },
      }[event.key];
      if (!act || (count === 0 && event.key !== "Insert")) return;
      event.preventDefault();
      act();
      choose(chosen);
    });
  }

  function number(id, apply) {
    $(id).addEventListener("change", () => {
      const value = $(id).valueAsNumber;
      if (!chosen || !Number.isFinite(value)) return;
      apply(list()[chosen.index], value);
      tell(false);
      choose(chosen);
    });
  }
  number("point-scalar", (item, x) => moveTo(x, item.opacity));
  number("point-opacity", (item, x) => { item.opacity = clamp(x, 0, 1); });
  number("point-midpoint", (item, x) => { item.midpoint = clamp(x, 0, 1); });
  number("point-sharpness", (item, x) => { item.sharpness = clamp(x, 0, 1); });
  $("point-color").addEventListener("input", () => {
    if (!chosen) return;
    const color = unhex($("point-color").value);
    if (chosen.kind === "color") list()[chosen.index].color = color;
    else list()[chosen.index].color = color.map((c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4));
    tell(false);
    draw();
  });
  $("point-add").onclick = () => {
    const kind = chosen?.kind ?? (isSurfaces() ? "surface" : "opacity");
    const items = chosen ? list() : [];
    const [a, b] = chosen ? [items[chosen.index], items[chosen.index + 1]] : [];
    const at = a && b ? (place(kind, a) + place(kind, b)) / 2 : (axis[0] + axis[1]) / 2;
    add(kind, at);
  };
  $("point-remove").onclick = remove;
  $("edit-colors").onclick = editColors;
  $("log").onchange = draw;
  $("zoom-range").onclick = zoomRange;
  $("zoom-all").onclick = zoomAll;
  new ResizeObserver(draw).observe(graph);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);

  let shownField = null;
  return {
    draw,
    field: () => { counts = null; },
    state: () => {
      if (dragging) return;
      preset = structuredClone(state.look.preset);
      surfaces = structuredClone(state.look.surfaces);
      if (chosen && !list()[chosen.index]) chosen = null;
      if (chosen?.kind === "color" && state.look.colormap) chosen = null;
      if (chosen && (chosen.kind === "surface") !== isSurfaces() && chosen.kind !== "color") chosen = null;
      const [low, high] = ends();
      // Another field has its own values; a range that left the axis brings the axis along.
      if (shownField !== state.field_id || low > axis[1] || high < axis[0]) {
        if (shownField === null || low > axis[1] || high < axis[0] || high - low > 20 * (axis[1] - axis[0])) zoomRange();
        else ask();
        shownField = state.field_id;
      }
      $("editor-title").textContent = isSurfaces() ? "Isovalues over values" : "Opacity over values";
      pointPanel();
      draw();
    },
    histogram: (message) => { counts = message; draw(); },
    addSurface: () => add("surface", (axis[0] + axis[1]) / 2),
    shownColor, hex, zoomRange,
  };
})();

// ---------------------------------------------------------------- panels

const panels = (() => {
  // ---- tabs
  const tabs = [...document.querySelectorAll('[role="tab"]')];
  function select(tab) {
    for (const other of tabs) {
      const isOn = other === tab;
      other.setAttribute("aria-selected", String(isOn));
      other.tabIndex = isOn ? 0 : -1;
      $(other.getAttribute("aria-controls")).hidden = !isOn;
    }
    editor.draw();
  }
  tabs.forEach((tab, i) => {
    tab.onclick = () => select(tab);
    tab.onkeydown = (event) => {
      const by = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      if (!by) return;
      const next = tabs[(i + by + tabs.length) % tabs.length];
      next.focus();
      select(next);
    };
  });

  // ---- what does not change
  function catalog() {
    const { catalog } = hello;
    $("version").textContent = `tetrascope ${catalog.version}`;
    $("model").replaceChildren(...catalog.models.map((name) => new Option(name.replace("-", " and "), name)));
    $("model").querySelector('[value="maximum-intensity"]').textContent = "maximum intensity";
    $("space").replaceChildren(...catalog.color_spaces.map((name) => new Option(name, name)));
    $("algorithm").replaceChildren(...catalog.algorithms.map((a) => new Option(a.name, a.name)));
    $("maps").replaceChildren(...catalog.colormaps.map((map) => {
      const swatch = make("canvas", { width: map.colors.length, height: 1, "aria-hidden": "true" });
      const c = swatch.getContext("2d");
      map.colors.forEach((color, i) => {
        c.fillStyle = editor.hex(color);
        c.fillRect(i, 0, 1, 1);
      });
      return make("button", { type: "button", "data-map": map.name, "aria-pressed": "false", onclick: () => link.command({ do: "colormap", name: map.name }) }, swatch, map.name);
    }));
    const stops = catalog.colormaps.find((map) => map.name === "inferno").colors.filter((_, i) => i % 3 === 0);
    $("legend-bar").style.background = `linear-gradient(90deg, ${stops.map(editor.hex).join(", ")})`;
  }

  function fieldInfo() {
    document.title = `${field.name} · Tetrascope`;
    $("name").textContent = field.name;
    const names = field.fields.map((f) => f.name);
    $("field").replaceChildren(...field.fields.map((f) => {
      const twice = names.filter((name) => name === f.name).length > 1;
      const value = twice ? `${f.association}:${f.name}` : f.name;
      const range = f.range ? ` [${short(f.range[0])}, ${short(f.range[1])}]` : "";
      const option = new Option(`${f.name}${twice ? ` (${f.association})` : ""}${range}`, value);
      option.selected = f.drawn;
      return option;
    }));
    $("field").disabled = field.fields.length < 2;
    $("description").textContent = field.description;
    $("notes").replaceChildren(...field.notes.map((note) => make("li", {}, note)));
    const count = field.steps.length;
    $("steps").hidden = count < 2;
    $("step").max = String(Math.max(0, count - 1));
    const step = field.steps[field.step];
    if (step) $("step-name").textContent = step.time === null ? `${field.step + 1}/${count}` : `t = ${short(step.time)}`;
  }

  // ---- the state
  const put = (id, value) => { if (document.activeElement !== $(id)) $(id).value = value; };

  function showState() {
    put("step", String(state.step));
    put("model", state.model);
    put("algorithm", state.algorithm);
    put("space", state.look.preset.color_space);
    $("space").disabled = Boolean(state.look.colormap);
    const [low, high] = state.range;
    put("low", exact(low));
    put("high", exact(high));
    put("unit-number", Number(state.look.unit_distance.toPrecision(4)));
    put("unit", String(Math.log10(state.look.unit_distance / unitScale())));
    put("cue", String(state.depth_cue ?? 0));
    $("cue-text").textContent = state.depth_cue === null ? "off" : short(state.depth_cue);
    $("orthographic").setAttribute("aria-pressed", String(state.camera.parallel_scale !== undefined));
    for (const button of document.querySelectorAll("#maps button")) button.setAttribute("aria-pressed", String(button.dataset.map === state.look.colormap));
    for (const button of document.querySelectorAll(".background")) {
      const color = button.dataset.color === "" ? null : button.dataset.color.split(",").map(Number);
      button.classList.toggle("on", JSON.stringify(color) === JSON.stringify(state.background));
    }
    $("command").textContent = state.command;
    $("short-command").textContent = state.short_command;
    surfaceList();
    clipList();
    algorithmPanel();
    honesty();
  }

  /** The unit distance at the slider's middle: a hundredth of the volume. */
  const unitScale = () => (field?.diagonal > 0 ? field.diagonal / 100 : 1);

  function surfaceList() {
    $("surfaces").hidden = state.model !== "isosurfaces";
    if ($("surface-list").contains(document.activeElement)) return;
    const surfaces = state.look.surfaces;
    $("surface-list").replaceChildren(...surfaces.map((surface, index) => make("div", { class: "surface" },
      make("span", { style: null, "aria-hidden": "true" }, "●"),
      make("input", {
        type: "number", step: "any", value: exact(surface.value), "aria-label": `Value of isosurface ${index + 1}`,
        onchange: (event) => {
          const next = structuredClone(surfaces);
          next[index].value = event.target.valueAsNumber;
          if (Number.isFinite(next[index].value)) link.command({ do: "isosurfaces", surfaces: next });
        },
      }),
      make("button", {
        type: "button", "aria-label": `Remove isosurface ${index + 1}`,
        onclick: () => link.command({ do: "isosurfaces", surfaces: surfaces.filter((_, i) => i !== index) }),
      }, "×"))));
    [...$("surface-list").querySelectorAll("span")].forEach((dot, index) => { dot.style.color = editor.hex(editor.shownColor(index)); });
  }

  // Two planes for each axis, at parts of the volume's box; others come from scene files.
  const along = (plane) => {
    const size = Math.hypot(...plane.normal);
    const axis = plane.normal.findIndex((n) => Math.abs(Math.abs(n) - size) < 1e-12 * size);
    return axis < 0 ? null : { axis, sign: Math.sign(plane.normal[axis]), at: plane.point[axis] };
  };

  function clipParts() {
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

  function clipCommand(parts, others) {
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

  function clipList() {
    const { parts, others } = clipParts();
    $("clip-others").textContent = others.length ? `${others.length} oblique ${others.length === 1 ? "plane" : "planes"} of a scene` : "";
    if ($("clip-list").contains(document.activeElement) && document.activeElement.type === "range") return;
    const [low, high] = field.bounds;
    $("clip-list").replaceChildren(...["x", "y", "z"].map((name, axis) => {
      const span = high[axis] - low[axis] || 1;
      const slider = (end) => {
        const value = (parts[axis][end] - low[axis]) / span;
        const word = end ? "greatest" : "least";
        const set = (event, moving) => {
          const next = clipParts();
          const pair = next.parts[axis];
          const at = low[axis] + span * event.target.valueAsNumber;
          pair[end] = end ? Math.max(at, pair[0]) : Math.min(at, pair[1]);
          const command = clipCommand(next.parts, next.others);
          state.clip = command.planes;
          if (moving) link.drag(command);
          else link.command(command);
        };
        return make("input", { type: "range", min: 0, max: 1, step: 0.002, value, "aria-label": `${word} ${name} that stays`, oninput: (event) => set(event, true), onchange: (event) => set(event, false) });
      };
      return make("div", { class: "clip" }, make("span", {}, name), slider(0), slider(1));
    }));
  }

  function algorithmPanel() {
    const about = hello.catalog.algorithms.find((a) => a.name === state.algorithm);
    for (const option of $("algorithm").options) {
      const why = state.reasons[option.value];
      option.textContent = why ? `${option.value} — not here` : option.value;
      option.disabled = Boolean(why);
      option.title = why ?? "";
    }
    const refused = Object.entries(state.reasons).filter(([, why]) => why).map(([, why]) => why);
    $("algorithm-text").textContent = about.title + ".";
    $("algorithm-text").title = [about.paper, ...refused].join("\n");
    if ($("settings").contains(document.activeElement)) return;
    $("settings").replaceChildren(...about.settings.map((setting) => {
      const value = state.settings[setting.name];
      const change = (event) => {
        const settings = { ...state.settings, [setting.name]: event.target.value };
        link.command({ do: "algorithm", name: state.algorithm, settings });
      };
      const { choice, integer, number } = setting.values;
      const [min, max] = integer ?? number ?? [];
      const input = choice
        ? make("select", { onchange: change }, ...choice.map((word) => new Option(word, word, false, word === value)))
        : make("input", { type: "number", min, max, step: integer ? 1 : "any", value, onchange: change });
      return make("label", { title: setting.about }, setting.name, input);
    }));
  }

  // ---- what is known of the picture
  const rows = (id, entries) => {
    const shown = entries.filter(([, value]) => value !== null && value !== undefined && value !== "");
    $(id).replaceChildren(...shown.map(([key, value]) => make("tr", {}, make("th", { scope: "row" }, key), make("td", {}, value))));
  };

  const words = { quick: "moving", refining: "refining", complete: "complete", difference: "difference" };

  function errorWords() {
    const header = picture.header();
    if (!header || header.kind === "quick" || header.kind === "refining") return null;
    if (!estimate || estimate.version !== header.version) return header.kind === "complete" ? "measuring…" : null;
    if (estimate.error) return `RMSE ${short(estimate.error.rmse)} (95 %: ≤ ${short(estimate.error.upper)})`;
    if (estimate.on_demand) return "not measured";
    return estimate.why ? `not measured: ${estimate.why}` : null;
  }

  function honesty() {
    const header = picture.header();
    if (!header || !state) return;
    const { statistics } = header;
    const isCurrent = estimate?.version === header.version && estimate.error;
    rows("honesty", [
      ["drawn by", `${header.algorithm}, ${header.adapter ?? "CPU"}`],
      ["promise", header.algorithm === state.algorithm ? state.promise : null],
      ["error", errorWords()],
      ["greatest", isCurrent ? `${short(estimate.error.greatest)} in ${estimate.error.sampled} pixels` : null],
      ["bound", statistics.error_bound ? `≤ ${short(statistics.error_bound)}` : null],
      ["time", `${milliseconds(header.draw_ms)}, packed in ${milliseconds(header.encode_ms)}`],
      ["memory", statistics.bytes_resident ? `${bytes(statistics.bytes_resident)} for the volume` : null],
      ["notes", statistics.notes.join("; ")],
    ]);
    const skip = ["cpu_seconds", "gpu_seconds", "bytes_resident", "error_bound", "notes"];
    const counters = Object.entries(statistics).filter(([key, value]) => !skip.includes(key) && value !== null);
    const more = [["settings", header.settings.replaceAll(",", ", ")], ["size", header.size.join("×")], ["file", bytes(header.bytes)], ["knots", String(state.knots)], ["moving frames", picture.moving()?.more.why]];
    rows("counters", [...more, ...counters.map(([key, value]) => [key.replaceAll("_", " "), String(value)])]);
    const moving = picture.moving();
    const latency = picture.latency();
    const rate = picture.rate();
    rows("moving", [
      ["drawn by", moving ? moving.algorithm : null],
      ["pixels", moving ? `${moving.size.join("×")} of ${moving.full.join("×")}` : null],
      ["time", moving ? `${milliseconds(moving.draw_ms)}, packed in ${milliseconds(moving.encode_ms)}` : null],
      ["latency", latency === null ? null : `${milliseconds(latency)}, median of ${picture.latencies.length}`],
      ["rate", rate === null ? null : `${rate.toFixed(0)} pictures in a second`],
    ]);
    $("measure").hidden = !(estimate?.version === header.version && estimate.on_demand);
    $("status-kind").textContent = `${header.algorithm} · ${words[header.kind]} · ${header.size.join("×")}`;
    $("status-error").textContent = errorWords() ?? "";
    $("status-time").textContent = milliseconds(header.draw_ms);
    $("status-latency").textContent = latency === null ? "" : `latency ${milliseconds(latency)}${rate === null ? "" : ` · ${rate.toFixed(0)} fps`}`;
  }

  function working(text, share = null) {
    $("working").hidden = text === null;
    if (text === null) return;
    $("working").querySelector("span").textContent = text;
    const bar = $("working").querySelector("progress");
    if (share === null) bar.removeAttribute("value");
    else bar.value = share;
  }

  // ---- controls
  $("field").onchange = () => link.command({ do: "field", name: $("field").value });
  $("step").oninput = () => steps.go($("step").valueAsNumber);
  $("step-back").onclick = () => steps.go(state.step - 1);
  $("step-on").onclick = () => steps.go(state.step + 1);
  $("play").onclick = () => steps.toggle();
  for (const button of document.querySelectorAll(".fit")) button.onclick = () => camera.fit(button.dataset.from);
  $("orthographic").onclick = () => link.command({ do: "orthographic", on: state.camera.parallel_scale === undefined });
  $("model").onchange = () => link.command({ do: "model", name: $("model").value });
  $("space").onchange = () => link.command({ do: "points", preset: { ...state.look.preset, color_space: $("space").value } });
  for (const id of ["low", "high"]) {
    $(id).onchange = () => {
      const [low, high] = [$("low").valueAsNumber, $("high").valueAsNumber];
      if (Number.isFinite(low) && Number.isFinite(high)) link.command({ do: "range", low, high });
    };
  }
  for (const button of document.querySelectorAll(".percent")) {
    button.onclick = () => {
      link.command({ do: "percentiles", low: Number(button.dataset.low), high: Number(button.dataset.high) });
      setTimeout(editor.zoomRange, 250);
    };
  }
  $("unit").oninput = () => link.drag({ do: "unit-distance", length: unitScale() * 10 ** $("unit").valueAsNumber });
  $("unit").onchange = () => link.command({ do: "unit-distance", length: unitScale() * 10 ** $("unit").valueAsNumber });
  $("unit-number").onchange = () => link.command({ do: "unit-distance", length: $("unit-number").valueAsNumber });
  $("cue").oninput = () => link.drag({ do: "depth-cue", strength: $("cue").valueAsNumber || null });
  $("cue").onchange = () => link.command({ do: "depth-cue", strength: $("cue").valueAsNumber || null });
  for (const button of document.querySelectorAll(".background")) {
    const color = button.dataset.color === "" ? null : button.dataset.color.split(",").map(Number);
    button.onclick = () => link.command({ do: "background", color });
  }
  $("background").oninput = () => {
    const linear = [1, 3, 5].map((i) => parseInt($("background").value.slice(i, i + 2), 16) / 255).map((c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4));
    link.command({ do: "background", color: [...linear, 1] });
  };
  $("surface-add").onclick = () => editor.addSurface();
  $("clip-none").onclick = () => link.command({ do: "clip", planes: [] });
  $("algorithm").onchange = () => link.command({ do: "algorithm", name: $("algorithm").value, settings: {} });
  $("difference").onclick = () => difference.toggle();
  $("legend-close").onclick = () => difference.off();
  $("measure").onclick = () => { link.send({ estimate: true }); $("measure").hidden = true; };
  $("reset").onclick = () => link.command({ do: "reset" });
  $("import").onclick = () => $("file").click();
  $("file").onchange = async () => {
    const [file] = $("file").files;
    $("file").value = "";
    if (!file) return;
    if (file.size > 1 << 20) {
      say(`${file.name} is too long for a preset or a scene.`, null, true);
      return;
    }
    const text = await file.text();
    const isJson = /^\s*[[{]/.test(text) && !/^\s*\[\w+\]\s*$/m.test(text.split("\n")[0]);
    if (isJson && !text.includes('"version"')) link.command({ do: "import-preset", text });
    else link.command({ do: "import-scene", text, json: isJson });
  };
  $("save").onclick = () => $("save-dialog").showModal();
  $("help").onclick = () => $("help-dialog").showModal();
  for (const button of document.querySelectorAll("dialog .close")) button.onclick = () => button.closest("dialog").close();

  async function copy(text, done) {
    try {
      await navigator.clipboard.writeText(text);
      say(done);
    } catch {
      // Without the right to the clipboard, the text is there to take.
      prompt("Copy this:", text);
    }
  }
  $("copy-command").onclick = () => copy(state.command, "The command is copied.");
  $("link").onclick = () => {
    const saved = toBase64(new TextEncoder().encode(JSON.stringify(state.saved)));
    copy(`${location.href.split("#")[0]}#${saved}`, "The address is copied. It holds the token: who has it can see and change this view.");
  };
  $("retry").onclick = () => link.retry();

  document.addEventListener("keydown", (event) => {
    const tag = event.target.tagName;
    if (["INPUT", "SELECT", "TEXTAREA"].includes(tag) || event.ctrlKey || event.metaKey || event.altKey) return;
    if (document.querySelector("dialog[open]") || event.target === $("editor") || event.target === $("colors")) return;
    const act = {
      0: () => camera.fit("+iso"),
      x: () => camera.fit("+x"), X: () => camera.fit("-x"),
      y: () => camera.fit("+y"), Y: () => camera.fit("-y"),
      z: () => camera.fit("+z"), Z: () => camera.fit("-z"),
      o: () => $("orthographic").click(),
      d: () => difference.toggle(),
      "?": () => $("help").click(),
      " ": tag === "BUTTON" ? null : () => steps.toggle(),
      1: () => select(tabs[0]), 2: () => select(tabs[1]), 3: () => select(tabs[2]),
    }[event.key];
    if (!act) return;
    event.preventDefault();
    act();
  });

  return {
    catalog,
    field: fieldInfo,
    state: showState,
    shown: honesty,
    honesty,
    working,
    progress: ({ share }) => { if (difference.isOn() && !difference.shows()) working("drawing the truth", share); },
  };
})();

link.open();
