// What is known of the picture: how it was drawn, how wrong it is, how long it took.

"use strict";

const knowledge = (() => {
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

  function tell() {
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

  return {
    tell, working,
    progress: ({ share }) => { if (difference.isOn() && !difference.shows()) working("drawing the truth", share); },
  };
})();
