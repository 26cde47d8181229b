// Values of the language and of the status, from and to text.

// "40deg" -> {number: 40, unit: "deg"}; numbers as they are.
export function parseQuantity(value) {
  if (typeof value === "number") return { number: value, unit: "" };
  const match = /^\s*(-?[\d.]+(?:e[+-]?\d+)?)\s*([^\d\s]*)\s*$/i.exec(String(value));
  return match ? { number: Number(match[1]), unit: match[2] } : null;
}

// "(1, 2m, 3)" or "rgb(0.1, 0.2, 0.3)" -> quantities
export function parseVector(value) {
  const inner = /\(([^()]*)\)/.exec(String(value));
  return inner ? inner[1].split(",").map((part) => parseQuantity(part) || { number: 0, unit: "" }) : [];
}

function encode(x) {
  const clipped = Math.min(1, Math.max(0, x));
  const shown = clipped <= 0.0031308 ? 12.92 * clipped : 1.055 * clipped ** (1 / 2.4) - 0.055;
  return Math.round(shown * 255).toString(16).padStart(2, "0");
}

// Linear "rgb(…)" -> "#rrggbb", sRGB-encoded as in the language
export function colorToHex(value) {
  const parts = parseVector(value);
  return parts.length === 3 ? "#" + parts.map((part) => encode(part.number)).join("") : "#000000";
}

// No more digits than a control can tell apart.
export function shortNumber(x) {
  return String(Number(x.toPrecision(6)));
}

export function count(n) {
  for (const [size, suffix] of [[1e9, " G"], [1e6, " M"], [1e3, " k"]]) {
    if (n >= size) return (n / size).toPrecision(3) + suffix;
  }
  return n.toFixed(0);
}

export function duration(seconds) {
  if (seconds < 9.95) return seconds.toFixed(1) + " s";
  if (seconds < 59.5) return seconds.toFixed(0) + " s";
  const whole = Math.round(seconds), two = (n) => String(n).padStart(2, "0");
  const minutes = Math.floor(whole / 60);
  return minutes < 60 ? `${minutes}:${two(whole % 60)}` : `${Math.floor(minutes / 60)}:${two(minutes % 60)}:${two(whole % 60)}`;
}

export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === true) made.setAttribute(name, "");
    else if (value !== false && value !== undefined) made.setAttribute(name, value);
  }
  made.append(...children);
  return made;
}
