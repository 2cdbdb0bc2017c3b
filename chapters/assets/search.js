/**
 * Results of a search, section by section, with the words of the text around what was found: on
 * the page of results, and in the dialog of Ctrl+K while one types.
 *
 * Pagefind loads the parts of its index that a query needs. Browsers refuse that for a page that
 * is opened from the disk, where Sphinx's own search, one file, takes its place on the page of
 * results, and the dialog leads there.
 */
(() => {
  const AT_ONCE = 5; // pages; each is a file of some kilobytes
  const SECTIONS = 3;
  const PAUSE = 150; // milliseconds without a key
  // What a question is made of, and each page has.
  const IDLE = new Set("an and are be can do does for function get getting how if in is it me my of on or should tell that the to what when where which why with".split(" "));
  // What other books call it, or who has not begun asks for.
  const HERE = {
    loss: "cost", losses: "costs", normalised: "whitened", begin: "install", started: "install", license: "licence",
    α: "alpha", γ: "gamma", κ: "kappa", λ: "lambda", μ: "mu", ρ: "rho", σ: "sigma", χ: "chi", ψ: "psi",
  };

  const here = document.currentScript.src;
  const isFile = location.protocol === "file:";
  const query = new URLSearchParams(location.search).get("q")?.trim() ?? "";

  const counted = ({ length }) => `${length} ${length === 1 ? "page" : "pages"}`;
  const nothing = (words) => `No page has “${words}”. Try fewer or other words.`;

  /** A word as the pages spell it. */
  function spelled(word) {
    const british = word.replace(/^\\/, "").replace(/(\w{3}i)z(e[drs]?|ers|ing|ations?)$/, "$1s$2")
      .replace(/(neighb|col)or/, "$1our").replace(/(cent|met)er/, "$1re").replace(/(model|label)(ed|ing)$/, "$1l$2");
    return HERE[british] ?? british;
  }

  /** The words of a query that tell pages apart; all of them where none does. */
  function telling(query) {
    const words = query.toLowerCase().split(/\s+/).map(spelled);
    const found = words.filter((word) => word.length > 1 && !IDLE.has(word)).join(" ") || words.join(" ");
    return found.length < 3 ? `"${found}"` : found; // else it is taken as the beginning of others
  }

  /** Whether a word begins as one of the query does: Pagefind also offers what shares one letter. */
  function hasWord(query, { excerpt }) {
    const marked = [...excerpt.matchAll(/<mark>([^<]*)<\/mark>/g)].map(([, word]) => word.toLowerCase());
    const begins = telling(query).replaceAll('"', "").split(/\s+/).map((word) => word.slice(0, 3));
    return marked.some((word) => begins.some((begin) => word.includes(begin)));
  }

  /** A link and the text around what was found there, whose words Pagefind has marked. */
  function found({ title, url, excerpt }) {
    const text = element("p", { className: "context" });
    text.innerHTML = excerpt;
    return [element("a", { href: url }, title), text];
  }

  /** How much a section has of what was asked; its heading counts most. */
  const score = ({ weighted_locations: places }) => places.reduce((sum, place) => sum + place.balanced_score, 0);

  function pageFound({ url, meta, excerpt, sub_results: sections }) {
    const own = sections.filter((section) => section.url.includes("#") && section.title !== meta.title)
      .sort((one, other) => score(other) - score(one)).slice(0, SECTIONS);
    const item = element("li", {}, ...found({ title: meta.title, url, excerpt }));
    if (own.length) {
      item.lastChild.remove();
      item.append(element("ul", {}, ...own.map((section) => element("li", {}, ...found(section)))));
    }
    return item;
  }

  // A worker that does not answer would leave the reader waiting, and so few pages need none.
  let loading;
  const load = () => loading ??= import(new URL("../pagefind/pagefind.js", here))
    .then(({ createInstance }) => createInstance({ noWorker: true }));

  /** Let the arrows lead from the query to the results and on. */
  function walk(around) {
    around.addEventListener("keydown", (event) => {
      const stops = [...around.querySelectorAll("input[name=q], ul.search a")];
      const next = stops[stops.indexOf(event.target) + { ArrowDown: 1, ArrowUp: -1 }[event.key]];
      if (next) event.preventDefault();
      next?.focus();
    });
  }

  async function showResults(place) {
    const status = element("p", { role: "status" }, "Searching …");
    const list = element("ul", { className: "search" });
    const more = element("button", { type: "button", className: "btn btn-outline-secondary", hidden: true }, "Show more");
    place.replaceChildren(status, list, more);
    const { results } = await (await load()).search(telling(query));
    status.textContent = results.length ? `${counted(results)} for “${query}”.` : nothing(query);
    async function show() {
      const next = results.splice(0, AT_ONCE);
      const pages = await Promise.all(next.map((result) => result.data()));
      if (!list.children.length && !pages.some((page) => hasWord(query, page))) {
        status.textContent = nothing(query);
        return null;
      }
      const items = pages.map(pageFound);
      list.append(...items);
      more.hidden = !results.length;
      return items[0];
    }
    more.addEventListener("click", async () => (await show())?.querySelector("a").focus());
    await show();
  }

  /** Lists in the dialog what is found, at each pause of the typing. */
  function showWhileTyping(dialog) {
    const input = dialog.querySelector("input[name=q]");
    const status = element("p", { role: "status" });
    const list = element("ul", { className: "search" });
    dialog.append(element("div", { className: "rs-found" }, status, list));
    let last = "";
    input.addEventListener("input", async () => {
      const words = last = input.value.trim();
      const pagefind = await load();
      const search = words ? await pagefind.debouncedSearch(telling(words), {}, PAUSE) : { results: [] };
      if (!search) return; // more was typed meanwhile
      const pages = await Promise.all(search.results.slice(0, AT_ONCE).map((result) => result.data()));
      if (words !== last) return;
      const own = pages.filter((page) => hasWord(words, page));
      status.textContent = own.length ? `${counted(search.results)}; Enter shows all, ↓ the next.` : words && nothing(words);
      list.replaceChildren(...own.map(pageFound));
    });
    // A result on this very page leads out of the dialog, too.
    list.addEventListener("click", ({ target }) => target.closest("a") && dialog.close());
  }

  const place = document.querySelector("#search-results");
  const dialog = document.querySelector("#pst-search-dialog");
  if (place) {
    place.parentElement.querySelector("form.bd-search input").value = query;
    walk(place.parentElement);
    if (isFile) {
      // It would fetch excerpts of pages, which browsers refuse.
      DOCUMENTATION_OPTIONS.SHOW_SEARCH_SUMMARY = false;
      for (const name of ["language_data.js", "searchtools.js", "../searchindex.js"]) {
        document.head.append(element("script", { src: new URL(name, here).href, async: false }));
      }
    } else if (query) {
      showResults(place);
    }
  }
  if (dialog && !isFile) {
    showWhileTyping(dialog);
    walk(dialog);
    // The theme's own listens to its field alone.
    dialog.addEventListener("keydown", ({ key }) => key === "Escape" && dialog.close());
  }
})();
