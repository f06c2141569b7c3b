// Pictures onto the screen, and how long they took.

"use strict";

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
    knowledge.tell();
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
