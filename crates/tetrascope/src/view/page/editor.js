// The transfer function: colors and opacities over the histogram, and what moves their points.

"use strict";

const editor = (() => {
  const { hex, unhex, toLinear, toSrgb, opacityAt, colorAt } = curve;
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
      const y = toY(opacityAt(preset, scalar), height);
      edge.push([x, y]);
      if (!isSurfaces()) {
        c.fillStyle = hex(colorAt(preset, scalar));
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
    return toSrgb(state.isosurfaces[index]?.color ?? [1, 1, 1]);
  }

  function drawColors() {
    const [c, width, height] = context(band);
    for (let x = 0; x < width; x += 1) {
      c.fillStyle = hex(colorAt(preset, toScalar(x, width)));
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
      opacity: () => ({ scalar, opacity: opacity ?? opacityAt(preset, scalar), midpoint: 0.5, sharpness: 0 }),
      color: () => ({ scalar, color: colorAt(preset, scalar) }),
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
    else list()[chosen.index].color = toLinear(color);
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
    shownColor, zoomRange,
  };
})();
