// Asked of a page by `tests/compare.rs`: what a person does with each viewer, and what comes of it.
addEventListener("load", async () => {
  const images = [...document.images].filter((image) => image.getAttribute("src"));
  for (const image of images) image.loading = "eager";
  await Promise.allSettled(images.map((image) => image.decode()));
  const unresolved = images.filter((image) => !image.complete || image.naturalWidth === 0);
  const viewers = [];
  for (const viewer of document.querySelectorAll(".viewer")) {
    const form = viewer.querySelector("form"), { model, right, mode, zoom } = form.elements;
    const stage = viewer.querySelector(".stage"), left = stage.querySelector(".left");
    const at = viewer.querySelector("input[type=range]");
    const change = (element) => element.dispatchEvent(new Event("change", { bubbles: true }));
    const cut = () => getComputedStyle(left).clipPath;
    const found = { shown: !viewer.hidden && viewer.getBoundingClientRect().height > 100 };
    const before = cut();
    at.value = 20;
    at.dispatchEvent(new Event("input", { bubbles: true }));
    found.slider = cut() !== before && cut().includes("80%");
    const box = stage.getBoundingClientRect();
    const place = { clientX: box.left + 0.75 * box.width, clientY: box.top + 9, bubbles: true, buttons: 1, pointerId: 1 };
    stage.dispatchEvent(new PointerEvent("pointermove", place));
    found.drag = Math.abs(at.value - 75) < 1 && cut().includes("25%");
    zoom.checked = true;
    change(zoom);
    found.zoom = getComputedStyle(left).transform.startsWith("matrix(8");
    zoom.checked = false;
    change(zoom);
    mode.value = "blink";
    change(form.querySelector("[value=blink]"));
    const seen = new Set();
    for (let i = 0; i < 8; i++) {
      seen.add(left.style.visibility);
      await new Promise((resolve) => setTimeout(resolve, 200));
    }
    found.blink = seen.size === 2;
    mode.value = "difference";
    change(form.querySelector("[value=difference]"));
    const words = viewer.querySelector(".says").textContent;
    const scale = viewer.querySelector(".scale");
    found.words = words.includes("minus the truth") ? !scale.hidden && scale.textContent.includes("e-") : words.includes("bits");
    const number = right.options.length;
    model.selectedIndex = model.options.length - 1;
    change(model);
    found.model = right.options.length > 1 && number > 1;
    viewers.push(found);
  }
  const answers = document.createElement("pre");
  answers.id = "answers";
  const wrong = window.wrong;
  answers.textContent = JSON.stringify({ images: images.length, unresolved: unresolved.map((i) => i.alt), viewers, wrong });
  document.body.append(answers);
});
