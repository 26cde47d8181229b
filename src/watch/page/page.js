// The page's parts, and the stream of events that feeds them.
import { count, duration, element, shortNumber } from "./format.js";
import { send, onRefusal } from "./server.js";
import { showParams, showSettings } from "./params.js";
import { pictureChanged, showSize } from "./picture.js";
import { reveal } from "./editor.js";

const $ = (id) => document.getElementById(id);
let scene = { errors: 0, warnings: 0 }, view = {}, status = { phase: "evaluating" }, connected = false;

// --- Small news ----------------------------------------------------------------------------------

let toastTimer = 0;
function toast(text) {
  $("toast").textContent = text;
  $("toast").hidden = false;
  clearTimeout(toastTimer);
  toastTimer = setTimeout(() => { $("toast").hidden = true; }, 3500);
}
onRefusal(toast);

async function copy(text, what) {
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    const area = element("textarea", { class: "visually-hidden" }, text);
    document.body.append(area);
    area.select();
    document.execCommand("copy");
    area.remove();
  }
  toast(`${what} copied`);
}

// --- Head and progress ---------------------------------------------------------------------------

const phases = { evaluating: "evaluating", rendering: "rendering", done: "done", paused: "paused", failed: "no picture" };

function showPhase() {
  const errors = scene.errors > 0;
  $("phase").className = !connected ? "lost" : errors ? "errors" : status.phase;
  const now = phases[status.phase] || status.phase;
  $("phase").querySelector("span").textContent = !connected ? "scnrender has ended, or can't be reached"
    : errors ? (status.phase === "failed" ? "the scene has errors" : "errors: this is the last good picture") : now;
}

function showStatus() {
  $("bar").value = status.fraction || 0;
  $("samples").textContent = `${Math.floor(status.samples)} of ${status.wanted}`;
  $("error").textContent = status.error === null ? "–" : `${(status.error * 100).toPrecision(2)} %`;
  $("rays").textContent = status.rays_per_second > 0 ? count(status.rays_per_second) : "–";
  const left = status.phase === "rendering" && status.seconds_left !== null ? `, ${duration(status.seconds_left)} left` : "";
  $("time").textContent = duration(status.seconds) + left;
  $("answered").textContent = status.first_picture === null ? "–" : `${(status.first_picture * 1000).toFixed(0)} ms`;
  $("size").textContent = `${status.width} × ${status.height}`;
  showSize(status.width, status.height);
  showPhase();
}

$("pause").addEventListener("click", () => send("pause", { on: view.paused ? 0 : 1 }));
$("copy-command").addEventListener("click", () => copy(view.command, "Command line"));

// --- Diagnostics ---------------------------------------------------------------------------------

function problemLine(line, first) {
  if (first) return element("span", { class: "head" }, line);
  const match = /^(\s*(?:\d+)?\s*(?:\||-->|=))(.*)$/.exec(line);
  if (!match) return line;
  const caret = /^\s*\^|^\s*~/.test(match[2]);
  return [element("span", { class: "gutter" }, match[1]), caret ? element("span", { class: "caret" }, match[2]) : match[2]];
}

function problem(diagnostic) {
  const pre = element("pre", {});
  diagnostic.text.replace(/\n+$/, "").split("\n").forEach((line, i) => pre.append(...[problemLine(line, i === 0)].flat(), "\n"));
  const box = element("div", { class: "problem " + diagnostic.severity }, pre);
  if (reveal && diagnostic.file) {
    const button = element("button", { type: "button" }, "Show in the editor");
    button.addEventListener("click", () => reveal(diagnostic));
    box.append(button);
  }
  return box;
}

function plural(n, what) {
  return `${n} ${what}${n === 1 ? "" : "s"}`;
}

function showProblems() {
  const list = scene.diagnostics || [];
  const counts = [];
  if (scene.errors) counts.push(plural(scene.errors, "error"));
  if (scene.warnings) counts.push(plural(scene.warnings, "warning"));
  $("problem-count").textContent = counts.join(", ") || (list.length ? plural(list.length, "note") : "");
  $("problem-count").className = scene.errors ? "error" : "warning";
  $("problem-list").replaceChildren(...list.map(problem));
  $("problems").hidden = list.length === 0;
}

// --- The scene and the view ----------------------------------------------------------------------

function showScene() {
  const name = scene.file.split("/").pop();
  $("file").textContent = name;
  $("file").title = scene.file;
  document.title = `${scene.errors ? "✗ " : ""}${name} – scnrender`;
  const stem = name.replace(/\.[^.]*$/, "");
  $("save-png").download = stem + ".png";
  $("save-exr").download = stem + ".exr";
  showParams(scene.params);
  const cameras = scene.cameras || [];
  $("camera").replaceChildren(...cameras.map((camera, i) =>
    element("option", { value: i }, camera.name || (cameras.length > 1 ? `camera ${i + 1}` : "the scene's camera"))));
  if (cameras.length === 0) $("camera").append(element("option", { value: "" }, "one that sees all"));
  if ($("tone").options.length === 0) {
    $("tone").append(...scene.tones.map((tone, i) => element("option", { value: i }, tone)));
  }
  showProblems();
  showPhase();
}

function showNumber(id, value) {
  for (const input of [$(id), $(id + "-number")]) {
    if (input && document.activeElement !== input) input.value = shortNumber(value);
  }
}

function showView() {
  if (view.exposure !== undefined) {
    $("exposure").min = Math.floor(view.scene_exposure) - 6;
    $("exposure").max = Math.ceil(view.scene_exposure) + 6;
    showNumber("exposure", view.exposure);
    $("tone").value = view.tone;
    $("reset-look").hidden = view.exposure === view.scene_exposure && view.tone === view.scene_tone;
  }
  if (view.camera !== null) $("camera").value = view.camera;
  $("fov-field").hidden = view.projection === 1 || view.projection === 3;
  $("aperture-field").hidden = view.projection > 1;
  if (view.fov !== undefined) {
    showNumber("fov", (view.fov * 180) / Math.PI);
    showNumber("aperture", view.aperture * 100);
  }
  $("moved").hidden = !view.moved;
  $("camera-text").value = view.camera_text;
  $("pause").setAttribute("aria-pressed", String(view.paused));
  $("pause").textContent = view.paused ? "Go on" : "Pause";
  showSettings(view.settings);
}

function onNumber(id, act) {
  for (const input of [$(id), $(id + "-number")].filter(Boolean)) {
    input.addEventListener(input.type === "range" ? "input" : "change", () => {
      if (input.value !== "") act(Number(input.value));
    });
  }
}

function sendLook(exposure, tone) {
  send("look", { exposure, tone });
}
onNumber("exposure", (exposure) => {
  view.exposure = exposure;
  $("exposure").value = exposure;
  $("exposure-number").value = exposure;
  sendLook(exposure, view.tone);
});
$("tone").addEventListener("change", () => { view.tone = Number($("tone").value); sendLook(view.exposure, view.tone); });
$("reset-look").addEventListener("click", () => send("look"));
onNumber("fov", (fov) => send("move", { kind: "fov", x: (fov * Math.PI) / 180 }, "fov"));
onNumber("aperture", (aperture) => send("move", { kind: "aperture", x: aperture / 100 }, "aperture"));
$("camera").addEventListener("change", () => send("camera", { number: $("camera").value }));
$("reset-camera").addEventListener("click", () => send("camera", view.camera === null ? {} : { number: view.camera }));
$("copy-camera").addEventListener("click", () => copy(view.camera_text, "Camera"));
$("reset-params").addEventListener("click", () => send("reset"));

// --- Events --------------------------------------------------------------------------------------

const events = new EventSource("events");
const on = (name, take) => events.addEventListener(name, (event) => {
  connected = true;
  take(JSON.parse(event.data));
});
on("scene", (data) => { scene = data; showScene(); });
on("view", (data) => { view = data; showView(); });
on("status", (data) => { status = data; showStatus(); });
on("picture", pictureChanged);
events.onerror = () => { connected = false; showPhase(); };
