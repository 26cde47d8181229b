// What stands behind a pixel.
import { element } from "./format.js";
import { reveal } from "./editor.js";

const box = document.getElementById("pixel");

const digits = (x, n = 4) => String(Number(x.toPrecision(n)));
const vector = (v) => "(" + v.map((x) => digits(Math.abs(x) < 1e-9 ? 0 : x)).join(", ") + ")";

// "ball (sphere)" at "scene.scn:12", and that line.
function nodeText(node) {
  const parts = [node.name ? `${node.name} (${node.kind})` : node.kind];
  if (node.file) {
    const place = `${node.file.split("/").pop()}:${node.line}`;
    parts.push(" ", reveal ? linkTo(node, place) : element("span", { class: "place" }, place));
    parts.push(element("span", { class: "source", title: node.source.trim() }, node.source.trim()));
  }
  return parts;
}

function linkTo(node, place) {
  const button = element("button", { class: "place", type: "button", title: "Show in the editor" }, place);
  button.addEventListener("click", () => reveal(node));
  return button;
}

function row(list, name, ...content) {
  list.append(element("dt", {}, name), element("dd", {}, ...content));
}

function addLights(list, pixel) {
  if (pixel.emits) row(list, "emits as", ...nodeText(pixel.emits));
  pixel.lights.forEach((light, i) => {
    const share = light.share === undefined ? "" : ` ${(light.share * 100).toFixed(0)} % of its direct light, ${digits(light.illuminance, 3)} lx`;
    row(list, i === 0 ? (pixel.hit ? "lit by" : "seen") : "and", ...nodeText(light), share ? element("span", { class: "hint" }, share) : "");
  });
  if (pixel.hit && pixel.lights.length === 0) row(list, "lit by", "no light directly");
}

export function showPixel(pixel) {
  if (!pixel) return;
  const list = element("dl", {});
  row(list, "pixel", `${pixel.x}, ${pixel.y}`);
  row(list, "radiance", vector(pixel.radiance), " W/m²/sr");
  const error = pixel.luminance_error === undefined ? "" : ` ± ${digits(pixel.luminance_error, 2)}`;
  row(list, "luminance", digits(pixel.luminance), error, " cd/m²");
  if (pixel.hit) {
    row(list, "object", ...nodeText(pixel.object));
    if (pixel.object.instance) row(list, "instance", `no. ${pixel.object.instance.number} `, ...nodeText({ kind: pixel.object.instance.name || "instance", ...pixel.object.instance, name: "" }));
    row(list, "material", ...nodeText(pixel.material));
    row(list, "depth", digits(pixel.depth), " m");
    row(list, "place", vector(pixel.position), " m");
    row(list, "normal", vector(pixel.normal), pixel.front ? "" : ", seen from behind");
  } else {
    row(list, "object", "nothing: the ray leaves the scene");
  }
  addLights(list, pixel);
  box.replaceChildren(list);
  const panel = document.getElementById("pixel-box");
  panel.open = true;
  panel.scrollIntoView({ block: "nearest" });
}
