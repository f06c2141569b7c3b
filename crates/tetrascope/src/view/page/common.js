// What all scripts of the page use: elements, numbers in words, messages, and what the server has told.

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
