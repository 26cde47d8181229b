// The picture itself: fetched when there is a newer one and the last is on the screen, and moved,
// asked and focused with mouse, fingers and keys.
import { send, ask } from "./server.js";
import { showPixel } from "./pixel.js";

const canvas = document.getElementById("picture");
const mark = document.getElementById("mark");
const context = canvas.getContext("2d", { alpha: false });

// --- Showing -----------------------------------------------------------------------------------

let newest = 0, shown = 0, busy = false;

async function draw() {
  const reply = await fetch("picture");
  if (!reply.ok) return;
  const [width, height, samples, number] = reply.headers.get("X-Picture").split(" ").map(Number);
  const image = new ImageData(new Uint8ClampedArray(await reply.arrayBuffer()), width, height);
  if (canvas.width !== width || canvas.height !== height) {
    canvas.width = width;
    canvas.height = height;
  }
  context.putImageData(image, 0, 0);
  document.getElementById("empty").hidden = true;
  canvas.dataset.number = number;
  canvas.dataset.samples = samples;
}

async function keepUp() {
  if (busy) return;
  busy = true;
  while (shown !== newest && !document.hidden) {
    const number = newest;
    try {
      await draw();
    } catch {
      break; // gone, as the stream of events will tell
    }
    shown = number;
    await new Promise(requestAnimationFrame);
  }
  busy = false;
}

export function pictureChanged(number) {
  newest = number;
  keepUp();
}

document.addEventListener("visibilitychange", keepUp);

// The film's size, by which the picture is laid out whatever pictures come.
export function showSize(width, height) {
  if (width > 0 && height > 0) {
    const frame = document.getElementById("frame");
    frame.style.setProperty("--aspect", width / height);
    // Twice the size is as far as pixels look well.
    frame.style.setProperty("--widest", Math.max(2 * width, 480) + "px");
  }
}

// --- Places ------------------------------------------------------------------------------------

function placeOf(event) {
  const box = canvas.getBoundingClientRect();
  const clamp = (x) => Math.min(0.999999, Math.max(0, x));
  return { x: clamp((event.clientX - box.left) / box.width), y: clamp((event.clientY - box.top) / box.height) };
}

function putMark(place) {
  const box = canvas.getBoundingClientRect(), frame = canvas.parentElement.getBoundingClientRect();
  mark.style.left = box.left - frame.left + place.x * box.width + "px";
  mark.style.top = box.top - frame.top + place.y * box.height + "px";
  mark.hidden = false;
}

async function inspect(place) {
  putMark(place);
  showPixel(await ask("pixel", place));
}

// --- Moving ------------------------------------------------------------------------------------

const merges = {
  orbit: (a, b) => ({ kind: "orbit", x: a.x + b.x, y: a.y + b.y }),
  pan: (a, b) => ({ kind: "pan", x: a.x + b.x, y: a.y + b.y }),
  dolly: (a, b) => ({ kind: "dolly", x: a.x * b.x, y: 0 }),
};

function move(kind, x, y = 0) {
  mark.hidden = true;
  send("move", { kind, x, y }, "move " + kind, merges[kind]);
}

const TURN = Math.PI; // of a drag over the picture's whole height
const pointers = new Map();
let drag = null;

function middle() {
  const all = [...pointers.values()];
  const x = all.reduce((sum, p) => sum + p.clientX, 0) / all.length;
  const y = all.reduce((sum, p) => sum + p.clientY, 0) / all.length;
  const spread = all.length < 2 ? 0 : Math.hypot(all[0].clientX - all[1].clientX, all[0].clientY - all[1].clientY);
  return { x, y, spread };
}

canvas.addEventListener("pointerdown", (event) => {
  canvas.setPointerCapture(event.pointerId);
  pointers.set(event.pointerId, event);
  drag = { from: middle(), moved: pointers.size > 1, pan: event.button === 2 || event.button === 1 || event.shiftKey || pointers.size > 1 };
});

canvas.addEventListener("pointermove", (event) => {
  if (!drag || !pointers.has(event.pointerId)) return;
  pointers.set(event.pointerId, event);
  const to = middle(), dx = to.x - drag.from.x, dy = to.y - drag.from.y;
  if (!drag.moved && Math.hypot(dx, dy) < 4) return;
  drag.moved = true;
  canvas.classList.add("dragging");
  const height = canvas.getBoundingClientRect().height;
  if (drag.pan) move("pan", -dx / height, dy / height);
  else move("orbit", (-dx / height) * TURN, (dy / height) * TURN);
  if (to.spread > 0 && drag.from.spread > 0) move("dolly", drag.from.spread / to.spread);
  drag.from = to;
});

function release(event) {
  if (!pointers.delete(event.pointerId)) return;
  if (pointers.size > 0) {
    drag = { from: middle(), moved: true, pan: pointers.size > 1 };
    return;
  }
  canvas.classList.remove("dragging");
  if (drag && !drag.moved && event.type === "pointerup" && event.button === 0) inspect(placeOf(event));
  drag = null;
}
canvas.addEventListener("pointerup", release);
canvas.addEventListener("pointercancel", release);
canvas.addEventListener("contextmenu", (event) => event.preventDefault());
canvas.addEventListener("dblclick", (event) => send("focus", placeOf(event)));
canvas.addEventListener("wheel", (event) => {
  event.preventDefault();
  const pixels = event.deltaY * (event.deltaMode === 1 ? 16 : event.deltaMode === 2 ? 400 : 1);
  move("dolly", Math.exp(Math.max(-300, Math.min(300, pixels)) * 0.0012));
}, { passive: false });

// --- Keys --------------------------------------------------------------------------------------

let cross = null; // where the cross stands

function moveCross(dx, dy) {
  const clamp = (x) => Math.min(0.999999, Math.max(0, x));
  cross = { x: clamp(cross.x + dx), y: clamp(cross.y + dy) };
  putMark(cross);
}

function withCross(event, dx, dy) {
  const step = event.shiftKey ? 0.002 : 0.02;
  if (dx || dy) moveCross(dx * step, dy * step);
  else if (event.key === "Enter") inspect(cross);
  else if (event.key === "f" || event.key === "F") send("focus", cross);
  else if (event.key === "Escape" || event.key === "x") {
    cross = null;
    mark.hidden = true;
  } else return false;
  return true;
}

function withCamera(event, dx, dy) {
  if (dx || dy) {
    if (event.shiftKey) move("pan", dx * 0.05, -dy * 0.05);
    else move("orbit", dx * 0.0873, -dy * 0.0873);
  } else if (event.key === "+" || event.key === "=") move("dolly", 0.9);
  else if (event.key === "-") move("dolly", 1 / 0.9);
  else if (event.key === "0" || event.key === "Home") document.getElementById("reset-camera").click();
  else if (event.key === "x" || event.key === "X") {
    cross = { x: 0.5, y: 0.5 };
    putMark(cross);
  } else return false;
  return true;
}

canvas.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  const [dx, dy] = arrows[event.key] || [0, 0];
  if (cross ? withCross(event, dx, dy) : withCamera(event, dx, dy)) event.preventDefault();
});
