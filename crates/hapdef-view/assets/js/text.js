// Texts that change in place: what a reader or a selection stands on stays.

/** Puts `text` into an element that has nothing else in it; leaves it alone where it says so already. */
export function put(element, text) {
  if (element.textContent === text) return;
  if (element.firstChild) element.firstChild.data = text;
  else element.textContent = text;
}

/** As many children of `list` as there are `items`, those that are there kept; `make` makes one more. */
export function keep(list, items, make) {
  while (list.children.length > items.length) list.lastElementChild.remove();
  while (list.children.length < items.length) list.append(make());
  return items.map((item, i) => [list.children[i], item]);
}

/** An element with children and a class. */
export function element(tag, className, ...children) {
  const made = document.createElement(tag);
  if (className) made.className = className;
  made.append(...children);
  return made;
}
