/** The question of a picture: on a page the one that stands there, else one made of `html`. */
export function predictionOf(el, html) {
  const template = document.createElement("template");
  template.innerHTML = html ?? "";
  return el.querySelector(".rs-predict") ?? template.content.firstElementChild;
}
