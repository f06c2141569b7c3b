// All else that can be chosen: tabs, fields, the scene, the algorithm, keys.

"use strict";

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
        c.fillStyle = curve.hex(color);
        c.fillRect(i, 0, 1, 1);
      });
      return make("button", { type: "button", "data-map": map.name, "aria-pressed": "false", onclick: () => link.command({ do: "colormap", name: map.name }) }, swatch, map.name);
    }));
    const stops = catalog.colormaps.find((map) => map.name === "inferno").colors.filter((_, i) => i % 3 === 0);
    $("legend-bar").style.background = `linear-gradient(90deg, ${stops.map(curve.hex).join(", ")})`;
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
    clip.state();
    algorithmPanel();
    knowledge.tell();
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
    [...$("surface-list").querySelectorAll("span")].forEach((dot, index) => { dot.style.color = curve.hex(editor.shownColor(index)); });
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
    link.command({ do: "background", color: [...curve.toLinear(curve.unhex($("background").value)), 1] });
  };
  $("surface-add").onclick = () => editor.addSurface();
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
      c: () => $("clip-handles").click(),
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
  };
})();

link.open();
