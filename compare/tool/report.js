"use strict";
// The slider under each scene: what lies left of it shows one renderer's picture, what lies right another's.
for (const wipe of document.querySelectorAll(".wipe")) {
  const stage = wipe.querySelector(".stage"), slider = wipe.querySelector("input");
  const move = (percent) => {
    const at = Math.min(100, Math.max(0, percent));
    stage.style.setProperty("--at", at + "%");
    slider.value = String(at);
  };
  const follow = (event) => {
    const box = stage.getBoundingClientRect();
    move(100 * (event.clientX - box.left) / box.width);
  };
  slider.addEventListener("input", () => move(Number(slider.value)));
  stage.addEventListener("pointerdown", (event) => { stage.setPointerCapture(event.pointerId); follow(event); });
  stage.addEventListener("pointermove", (event) => { if (event.buttons) follow(event); });
  wipe.querySelector(".left").addEventListener("change", (event) => { wipe.querySelector(".over").src = event.target.value; });
  wipe.querySelector(".right").addEventListener("change", (event) => { wipe.querySelector(".under").src = event.target.value; });
}
