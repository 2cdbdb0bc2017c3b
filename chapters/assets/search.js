/**
 * Results of a search, section by section, with the words of the text around what was found.
 *
 * Pagefind loads the parts of its index that a query needs. Browsers refuse that for a page that
 * is opened from the disk, where Sphinx's own search, one file, takes its place.
 */

const AT_ONCE = 5; // pages; each is a file of some kilobytes
const SECTIONS = 3;

const query = new URLSearchParams(location.search).get("q")?.trim() ?? "";
const place = document.querySelector("#search-results");

const NOTHING = `No page has “${query}”. Try fewer or other words.`;

/** Whether a word begins as one of the query does: Pagefind also offers what shares one letter. */
function hasTheQuery({ excerpt }) {
  const marked = [...excerpt.matchAll(/<mark>([^<]*)<\/mark>/g)].map(([, word]) => word.toLowerCase());
  const begins = query.toLowerCase().split(/\s+/).map((word) => word.slice(0, 3));
  return marked.some((word) => begins.some((begin) => word.includes(begin)));
}

function make(name, attributes = {}, ...children) {
  const made = Object.assign(document.createElement(name), attributes);
  made.append(...children);
  return made;
}

/** A link and the text around what was found there, whose words Pagefind has marked. */
function found({ title, url, excerpt }) {
  const text = make("p", { className: "context" });
  text.innerHTML = excerpt;
  return [make("a", { href: url }, title), text];
}

function pageFound({ url, meta, excerpt, sub_results: sections }) {
  const own = sections.filter((section) => section.url.includes("#")).slice(0, SECTIONS);
  const item = make("li", {}, ...found({ title: meta.title, url, excerpt }));
  if (own.length) {
    item.lastChild.remove();
    item.append(make("ul", {}, ...own.map((section) => make("li", {}, ...found(section)))));
  }
  return item;
}

async function showResults() {
  const status = make("p", { role: "status" }, "Searching …");
  const list = make("ul", { className: "search" });
  const more = make("button", { type: "button", className: "btn btn-outline-secondary", hidden: true }, "Show more");
  place.replaceChildren(status, list, more);
  const pagefind = await import(new URL("../pagefind/pagefind.js", place.dataset.script));
  // A worker that does not answer would leave the reader waiting, and so few pages need none.
  await pagefind.options({ noWorker: true });
  const { results } = await pagefind.search(query);
  const count = `${results.length} ${results.length === 1 ? "page has" : "pages have"}`;
  status.textContent = results.length ? `${count} “${query}”.` : NOTHING;
  async function show() {
    const next = results.splice(0, AT_ONCE);
    const pages = await Promise.all(next.map((result) => result.data()));
    if (!list.children.length && !pages.some(hasTheQuery)) {
      status.textContent = NOTHING;
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

function loadInOrder(names) {
  for (const src of names) document.head.append(make("script", { src, async: false }));
}

const here = document.currentScript.src;
place.dataset.script = here;
place.parentElement.querySelector("form.bd-search input").value = query;
if (location.protocol === "file:") {
  // It would fetch excerpts of pages, which browsers refuse.
  DOCUMENTATION_OPTIONS.SHOW_SEARCH_SUMMARY = false;
  const files = ["language_data.js", "searchtools.js", "../searchindex.js"];
  loadInOrder(files.map((name) => new URL(name, here).href));
} else if (query) {
  showResults();
}
