import { htmlElement } from "./controls.js";
import { KEYS_STAY } from "./scene.js";

/** The question of a picture: on a page the one that stands there, else one made of `html`. */
export function predictionOf(el, html) {
  const template = document.createElement("template");
  template.innerHTML = html ?? "";
  return el.querySelector(".rs-predict") ?? template.content.firstElementChild;
}

/** Put a button into each answer that calls `show`, which brings the picture where it is seen. */
export function offerToShow(el, show) {
  for (const acts of el.querySelectorAll(".rs-predict .rs-acts")) {
    const button = htmlElement("button", { type: "button", "data-show": true, ...KEYS_STAY }, "Show it");
    button.addEventListener("click", show);
    acts.prepend(button, " ");
  }
}
