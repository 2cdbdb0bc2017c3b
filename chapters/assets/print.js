// Paper is white and cannot be opened: a page that is dark on the screen is printed light, and a box
// that belongs on paper is open there. Answers to questions and exercises stand at its end.
addEventListener("beforeprint", () => {
  const { dataset } = document.documentElement, { theme } = dataset;
  const closed = [...document.querySelectorAll("details:is(.rs-on-paper, .sd-dropdown):not([open])")];
  dataset.theme = "light";
  for (const box of closed) box.open = true;
  const putBack = answersLast();
  addEventListener("afterprint", () => {
    dataset.theme = theme;
    for (const box of closed) box.open = false;
    putBack();
  }, { once: true });
});

// Put answers to the end of the page, each behind its question or number; what returns undoes it.
function answersLast() {
  const article = document.querySelector("article");
  const boxes = [...article?.querySelectorAll("details.sd-dropdown") ?? []]
    .filter((box) => box.querySelector("summary").textContent.trim() === "Answer");
  const places = boxes.map((box) => box.parentNode.insertBefore(new Comment(), box));
  const told = [...article?.querySelectorAll(".rs-predict p:has(> .is-right:first-child)") ?? []].map((answer) => {
    const question = answer.closest("fieldset").querySelector("legend").textContent.replace("Predict: ", "");
    return element("p", {}, element("strong", {}, question), " ", ...answer.cloneNode(true).childNodes);
  });
  const numbered = boxes.map((box, k) => {
    const number = places[k].previousElementSibling?.querySelector("strong")?.textContent ?? "";
    return element("div", { className: number.length > 4 ? "rs-long" : "" }, element("strong", {}, number), box);
  });
  const letters = [...article?.querySelectorAll(".rs-quiz form") ?? []]
    .map((form, k) => `${k + 1} ${[...form.querySelectorAll(".rs-option:has(.rs-correct) b")].map((b) => b.textContent).join(" and ")}`);
  if (letters.length) told.push(element("p", {}, element("strong", {}, "Quiz: "), letters.join(", ")));
  const all = element("section", { className: "rs-answers" }, element("h2", {}, "Answers"), ...told, ...numbered);
  if (told.length + numbered.length) article.append(all);
  return () => {
    places.forEach((place, k) => place.replaceWith(boxes[k]));
    all.remove();
  };
}
