"use strict";
// Without this script the page shows all lights, each picture half ours and half Cycles'.
const controls = document.querySelector(".controls");
const sections = [...document.querySelectorAll("section[data-kind]")];
const slider = document.querySelector("#wipe");

function show(kind) {
  for (const section of sections) section.hidden = section.dataset.kind !== kind;
}

function wipe(share) {
  const percent = Math.min(100, Math.max(0, share));
  document.documentElement.style.setProperty("--wipe", `${percent}%`);
  slider.value = percent;
}

for (const radio of document.querySelectorAll("input[name=kind]")) {
  radio.addEventListener("change", () => show(radio.value));
  if (radio.checked) show(radio.value);
}
slider.addEventListener("input", () => wipe(Number(slider.value)));
for (const picture of document.querySelectorAll(".wipe")) {
  const follow = (event) => {
    if (event.type === "pointermove" && event.buttons === 0) return;
    const box = picture.getBoundingClientRect();
    wipe((100 * (event.clientX - box.left)) / box.width);
  };
  picture.addEventListener("pointerdown", follow);
  picture.addEventListener("pointermove", follow);
  picture.addEventListener("dragstart", (event) => event.preventDefault());
}
controls.hidden = false;
