// Elements of the page.

/** The element with this name. */
export const by = (id) => document.getElementById(id);

/** A new element with properties (`class`, `onclick`, attributes) and children, which are texts or elements. */
export function make(tag, properties = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (value === true) element.setAttribute(name, "");
    else if (value !== false && value !== null && value !== undefined) element.setAttribute(name, value);
  }
  element.append(...children.flat().filter((child) => child !== null && child !== undefined));
  return element;
}

/** A table of texts or elements, which scrolls on a narrow screen. */
export function table(caption, heads, rows) {
  const head = make("tr", {}, heads.map((text) => make("th", { scope: "col" }, text)));
  const body = rows.map((cells) => make("tr", {}, cells.map((cell) => make("td", {}, cell ?? ""))));
  const whole = make("table", {}, make("caption", {}, caption), make("thead", {}, head), make("tbody", {}, body));
  return make("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": caption }, whole);
}

const SVG = "http://www.w3.org/2000/svg";

/** Lowest and highest value of the parts of a recording. */
export const range = (parts) =>
  [Math.min(...parts.map(([low]) => low)), Math.max(...parts.map(([, high]) => high))];

/** The course of a column: its lowest and highest value in parts of the recording. */
export function course(parts, about) {
  const [low, high] = range(parts);
  const height = (x) => (high > low ? 2 + (28 * (high - x)) / (high - low) : 16);
  const at = (k) => ((k + 0.5) * 120) / parts.length;
  const above = parts.map(([, own], k) => `${at(k)},${height(own)}`);
  const below = parts.map(([own], k) => `${at(k)},${height(own)}`).reverse();
  const svg = document.createElementNS(SVG, "svg"), shape = document.createElementNS(SVG, "polygon");
  svg.setAttribute("class", "course");
  svg.setAttribute("viewBox", "0 0 120 32");
  svg.setAttribute("preserveAspectRatio", "none");
  svg.setAttribute("role", "img");
  svg.setAttribute("aria-label", about);
  shape.setAttribute("points", [...above, ...below].join(" "));
  svg.append(shape);
  return svg;
}

/** A number with four digits. */
export const short = (x) => (Number.isFinite(x) ? String(Number(x.toPrecision(4))) : "");

/** Saves a blob as a file of the computer. */
export function download(blob, name) {
  const link = make("a", { href: URL.createObjectURL(blob), download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}

/** Sizes for people. */
export function size(bytes) {
  const units = ["bytes", "kB", "MB", "GB"];
  let k = 0;
  for (; bytes >= 1000 && k < 3; k++) bytes /= 1000;
  return `${k ? bytes.toPrecision(3) : bytes} ${units[k]}`;
}
