// Elements of the page, made without any text that is read as HTML.

/** An element with a class, children (elements or texts) and properties. */
export function element(tag, className, children = [], properties = {}) {
  const made = document.createElement(tag);
  if (className) made.className = className;
  made.append(...children);
  Object.assign(made, properties);
  return made;
}

/** A titled part of the panel. */
export function section(title, children) {
  return element("section", "section", [element("h2", "", [title]), ...children]);
}

/** A button with a text that tells what it does. */
export function button(text, title, onclick, className = "") {
  return element("button", `button ${className}`, [text], { type: "button", title, onclick });
}

/** A slider with its name, value and unit; `onset` is called when it is let go. */
export function slider({ name, low, high, step, value, show, oninput, onset }) {
  const told = element("output", "value", [show(value)]);
  const range = element("input", "range", [], { type: "range", min: low, max: high, step });
  range.value = value;
  range.setAttribute("aria-label", name);
  range.oninput = () => {
    told.textContent = show(Number(range.value));
    oninput?.(Number(range.value));
  };
  range.onchange = () => onset?.(Number(range.value));
  const row = element("label", "slider", [element("span", "name", [name]), told, range]);
  const set = (to) => {
    if (document.activeElement === range && range.matches(":active")) return;
    range.value = to;
    told.textContent = show(Number(to));
  };
  return { row, set, range };
}

/** Buttons of which one is chosen. */
export function choice(options, onchoose) {
  const buttons = options.map(({ value, text, title }) => {
    const made = button(text, title, () => onchoose(value), "segment");
    made.dataset.value = value;
    return made;
  });
  const set = (value) => {
    for (const made of buttons) {
      made.setAttribute("aria-pressed", String(made.dataset.value === String(value)));
    }
  };
  return { row: element("div", "segments", buttons), set, buttons };
}

/** A switch with a coloured mark, which is the legend of what it shows. */
export function toggle({ text, title, colors, on, onset }) {
  const box = element("input", "", [], { type: "checkbox", checked: on });
  box.onchange = () => onset(box.checked);
  const marks = colors.map((color) => {
    const mark = element("span", "mark");
    mark.style.background = color;
    return mark;
  });
  return element("label", "toggle", [box, element("span", "", [text]), ...marks], { title });
}
