// A control for each `param` of the scene, by its type and range.
import { parseQuantity, parseVector, colorToHex, shortNumber, element } from "./format.js";
import { send } from "./server.js";

const box = document.getElementById("params");
let shape = ""; // of the controls that are there
let controls = new Map(); // name -> {show(value), field}

function set(name, value) {
  send("set", { name, value }, "set " + name);
}

// A slider and a number, which follow each other.
function numberControl(param, id) {
  const min = param.min === undefined ? null : parseQuantity(param.min);
  const max = param.max === undefined ? null : parseQuantity(param.max);
  if (max && param.exclude_max) max.number -= param.type === "int" ? 1 : Math.abs(max.number) * 1e-6 || 1e-9;
  const unit = (parseQuantity(param.default) || { unit: "" }).unit;
  const whole = param.type === "int";
  // Of a slider, what a step is worth; the value itself may lie between.
  const step = whole ? 1 : min && max ? 10 ** Math.floor(Math.log10((max.number - min.number) / 200)) : 0;
  const number = element("input", { type: "number", id: min && max ? `${id}-n` : id, step: whole ? 1 : "any",
    min: min ? min.number : undefined, max: max ? max.number : undefined });
  const row = element("div", { class: "row" });
  let slider = null;
  if (min && max) {
    slider = element("input", { type: "range", id, min: min.number, max: max.number, step: whole ? 1 : "any" });
    slider.addEventListener("input", () => {
      const rounded = Math.min(max.number, Math.max(min.number, Math.round(slider.value / step) * step));
      number.value = shortNumber(rounded);
      set(param.name, number.value + unit);
    });
    number.setAttribute("aria-label", `${param.name}, as a number`);
    row.append(slider);
  }
  number.addEventListener("change", () => {
    if (number.value === "") return;
    if (slider) slider.value = number.value;
    set(param.name, number.value + unit);
  });
  row.append(number);
  return { body: row, unit, show(value) {
    const quantity = parseQuantity(value);
    if (!quantity) return;
    number.value = shortNumber(quantity.number);
    if (slider) slider.value = quantity.number;
  } };
}

function boolControl(param, id) {
  const input = element("input", { type: "checkbox", id, role: "switch" });
  input.addEventListener("change", () => set(param.name, String(input.checked)));
  return { body: input, show(value) { input.checked = value === true || value === "true"; } };
}

function choiceControl(param, id) {
  const input = element("select", { id }, ...param.choices.map((choice) => element("option", { value: choice }, String(choice))));
  input.addEventListener("change", () => set(param.name, input.value));
  return { body: input, show(value) { input.value = String(value); } };
}

function colorControl(param, id) {
  const input = element("input", { type: "color", id });
  input.addEventListener("input", () => set(param.name, input.value));
  return { body: input, show(value) { input.value = /^#[0-9a-f]{6}$/i.test(value) ? value : colorToHex(value); } };
}

function vectorControl(param, id) {
  const parts = parseVector(param.default);
  const inputs = parts.map((part, i) => element("input", { type: "number", step: "any", id: i === 0 ? id : `${id}-${i}`,
    "aria-label": `${param.name}, ${"xyzw"[i] || i}` }));
  const change = () => set(param.name, "(" + inputs.map((input, i) => (input.value || 0) + parts[i].unit).join(", ") + ")");
  for (const input of inputs) input.addEventListener("change", change);
  return { body: element("div", { class: "row vector" }, ...inputs), unit: parts.length ? parts[0].unit : "",
    show(value) { parseVector(value).forEach((part, i) => { if (inputs[i]) inputs[i].value = shortNumber(part.number); }); } };
}

function textControl(param, id) {
  const input = element("input", { type: "text", id, spellcheck: "false" });
  input.addEventListener("change", () => set(param.name, input.value));
  return { body: input, show(value) { input.value = value === null ? "" : String(value); } };
}

function makeControl(param, id) {
  if (param.choices) return choiceControl(param, id);
  if (param.type === "bool") return boolControl(param, id);
  if (param.type === "color") return colorControl(param, id);
  if (param.type === "vector") return vectorControl(param, id);
  if (param.type === "string") return textControl(param, id);
  return numberControl(param, id);
}

const unitNames = { deg: "°" };

function makeField(param) {
  const id = "param-" + param.name;
  const control = makeControl(param, id);
  const undo = element("button", { class: "undo", type: "button", title: "As the scene says", "aria-label": `${param.name} as the scene says` }, "↺");
  undo.addEventListener("click", () => send("set", { name: param.name }, "set " + param.name));
  const label = element("label", { for: id }, element("span", { class: "name" }, param.name));
  if (control.unit) label.append(element("span", { class: "unit" }, unitNames[control.unit] || control.unit));
  label.append(undo);
  const field = element("div", { class: "field" }, label, control.body);
  if (param.description) field.append(element("span", { class: "about" }, param.description));
  controls.set(param.name, { ...control, field, undo });
  return field;
}

export function showParams(params) {
  const newShape = JSON.stringify(params.map(({ value, ...rest }) => rest));
  if (newShape !== shape) {
    shape = newShape;
    controls = new Map();
    box.replaceChildren(...params.map(makeField));
    if (params.length === 0) {
      box.append(element("p", { class: "hint" }, "The scene declares no ", element("code", {}, "param"), "."));
    }
  }
  for (const param of params) {
    const { show, field } = controls.get(param.name);
    // What is being typed or dragged knows better.
    const active = document.activeElement;
    const busy = field.contains(active) && active.matches("input[type=number], input[type=text], :active");
    if (!busy) show(param.value);
  }
}

export function showSettings(settings) {
  let any = false;
  for (const [name, { field, undo }] of controls) {
    const isSet = Object.hasOwn(settings, name);
    field.classList.toggle("set", isSet);
    undo.hidden = !isSet;
    any ||= isSet;
  }
  document.getElementById("reset-params").hidden = !any;
}
