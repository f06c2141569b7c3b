// The viewer of a scene: two of its pictures, by a slider or in turn, and how one differs from the
// truth. Pictures are those of the galleries; without this script the page lacks the viewer alone.
"use strict";
for (const section of document.querySelectorAll("section[id^='scene-']")) {
  const viewer = section.querySelector(".viewer");
  const galleries = new Map();
  for (const gallery of section.querySelectorAll(".gallery"))
    if (gallery.children.length > 1) galleries.set(gallery.dataset.model, [...gallery.children]);
  if (viewer && galleries.size > 0) start(viewer, galleries);
}

function start(viewer, galleries) {
  const form = viewer.querySelector("form");
  const { model, left, right, mode, zoom } = form.elements;
  const stage = viewer.querySelector(".stage");
  const images = { left: stage.querySelector(".left"), right: stage.querySelector(".right") };
  const slider = viewer.querySelector(".slider"), at = slider.querySelector("input");
  const scale = viewer.querySelector(".scale"), says = viewer.querySelector(".says");
  let blinking = 0;

  const name = (picture) => `${picture.dataset.algorithm} ${picture.dataset.words}`;
  const options = (select, names, chosen) => {
    select.replaceChildren(...names.map((text, i) => new Option(text, i, false, i === chosen)));
  };
  const pictures = () => [...galleries.values()][model.value];

  function chooseModel() {
    const before = [left, right].map((select) => select.selectedOptions[0]?.text);
    const names = pictures().map(name);
    [left, right].forEach((select, i) => options(select, names, Math.max(names.indexOf(before[i]), before[i] ? 0 : i)));
    update();
  }

  function update() {
    const chosen = { left: pictures()[left.value], right: pictures()[right.value] };
    const map = chosen.right.querySelector("img.map");
    const isDifference = mode.value === "difference";
    clearInterval(blinking);
    for (const side of ["left", "right"]) {
      images[side].src = chosen[side].querySelector("img.drawn").src;
      images[side].alt = name(chosen[side]);
      images[side].style.visibility = "";
    }
    slider.hidden = mode.value !== "slide";
    stage.classList.toggle("whole", mode.value !== "slide");
    scale.hidden = !(isDifference && map);
    says.textContent = `${name(chosen.left)} on the left, ${name(chosen.right)} on the right`;
    if (mode.value === "blink") {
      says.textContent = `${name(chosen.left)} and ${name(chosen.right)} in turn`;
      let on = true;
      blinking = setInterval(() => {
        on = !on;
        images.left.style.visibility = on ? "" : "hidden";
      }, 600);
    } else if (isDifference && map) {
      images.left.src = map.src;
      images.left.alt = map.alt;
      const [low, high] = scale.querySelectorAll("i");
      low.textContent = `−${map.dataset.end}`;
      high.textContent = map.dataset.end;
      says.textContent = `${name(chosen.right)} minus the truth: blue is darker, red is brighter, in the channel that differs most`;
    } else if (isDifference) {
      images.left.src = images.right.src;
      const isTruth = chosen.right === pictures()[0];
      says.textContent = isTruth ? "the truth: choose another picture on the right" : `${name(chosen.right)} has the truth's very bits`;
    }
    const [x, y] = chosen.right.dataset.worst.split(" ");
    for (const image of Object.values(images)) {
      image.style.transformOrigin = `${x}% ${y}%`;
      image.style.transform = zoom.checked ? "scale(8)" : "";
    }
    move();
  }

  // The slider's place is on the stage; a picture that is larger than the stage is cut there, too.
  function move() {
    const place = Number(at.value), origin = Number(images.left.style.transformOrigin.split("%")[0]);
    const cut = zoom.checked ? origin + (place - origin) / 8 : place;
    stage.style.setProperty("--at", `${place}%`);
    images.left.style.clipPath = mode.value === "slide" ? `inset(0 ${100 - cut}% 0 0)` : "none";
  }

  stage.addEventListener("pointerdown", (event) => stage.setPointerCapture(event.pointerId));
  stage.addEventListener("pointermove", (event) => {
    if (mode.value !== "slide" || !event.buttons) return;
    const box = stage.getBoundingClientRect();
    at.value = (100 * (event.clientX - box.left)) / box.width;
    move();
  });
  at.addEventListener("input", move);
  form.addEventListener("change", (event) => (event.target === model ? chooseModel() : update()));
  form.addEventListener("submit", (event) => event.preventDefault());
  options(model, [...galleries.keys()], 0);
  for (const part of Object.values(images)) part.draggable = false;
  viewer.hidden = false;
  chooseModel();
}
