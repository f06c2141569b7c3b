// Colors and opacities between the points of a preset, and colors in sRGB and linear.

"use strict";

const curve = (() => {
  const hex = (color) => "#" + color.map((c) => Math.round(255 * clamp(c, 0, 1)).toString(16).padStart(2, "0")).join("");
  const unhex = (text) => [1, 3, 5].map((i) => parseInt(text.slice(i, i + 2), 16) / 255);
  const toLinear = (color) => color.map((c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4));
  const toSrgb = (color) => color.map((c) => (c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055));

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

  function opacityAt(preset, x) {
    const points = preset.opacities;
    let i = 0;
    while (i < points.length && points[i].scalar <= x) i += 1;
    if (i === 0) return points[0].opacity;
    if (i === points.length) return points.at(-1).opacity;
    const [a, b] = [points[i - 1], points[i]];
    return between(a, b, (x - a.scalar) / (b.scalar - a.scalar));
  }

  /** The color at a value, mixed in sRGB: the picture itself is mixed by the server. */
  function colorAt(preset, x) {
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

  return { hex, unhex, toLinear, toSrgb, opacityAt, colorAt };
})();
