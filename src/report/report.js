"use strict";

// One view at a time.
for (const viewer of document.querySelectorAll(".viewer")) {
  const links = [...viewer.querySelectorAll("nav a")];
  const views = [...viewer.querySelectorAll(".view")];
  const show = (shown) => {
    views.forEach((view, k) => { view.hidden = k !== shown; });
    links.forEach((link, k) => k === shown ? link.setAttribute("aria-current", "true") : link.removeAttribute("aria-current"));
  };
  if (links.length === 0) continue;
  links.forEach((link, k) => link.addEventListener("click", (event) => { event.preventDefault(); show(k); }));
  const asked = views.findIndex((view) => "#" + view.id === location.hash);
  show(Math.max(asked, 0));
}

const make = (tag, className, text) => {
  const element = document.createElement(tag);
  element.className = className;
  if (text !== undefined) element.textContent = text;
  return element;
};

// Original and stand-in under a slider, the difference beside them; all are enlarged and moved together.
for (const panels of document.querySelectorAll(".panels")) {
  const [original, standIn, difference] = [...panels.querySelectorAll("img")];
  const ratio = panels.dataset.width + " / " + panels.dataset.height;
  const stage = (...images) => {
    const element = make("div", "stage");
    element.style.aspectRatio = ratio;
    for (const image of images) {
      const layer = make("div", "layer");
      layer.append(image);
      element.append(layer);
    }
    return element;
  };
  const compare = stage(original, standIn);
  const beside = stage(difference);
  const handle = make("div", "handle");
  compare.append(handle, make("span", "label left", "original"), make("span", "label right", "stand-in"));
  beside.append(make("span", "label left", "difference"));
  panels.replaceChildren(compare, beside);
  panels.classList.add("live");

  const tools = make("div", "tools");
  const slider = make("input", "");
  Object.assign(slider, { type: "range", min: 0, max: 100, step: 0.1, value: 50, ariaLabel: "How much of the original is shown" });
  const button = (text, title, action) => {
    const element = make("button", "", text);
    Object.assign(element, { type: "button", title });
    element.addEventListener("click", action);
    return element;
  };
  const shown = make("output", "");
  const flip = button("Flip", "Original and stand-in in turn", () => wipe(slider.value > 50 ? 0 : 100));
  const turn = button("Blink", "Flips twice a second", () => {
    clearInterval(turn.timer);
    const on = turn.getAttribute("aria-pressed") !== "true";
    turn.setAttribute("aria-pressed", on);
    if (on) turn.timer = setInterval(() => flip.click(), 500);
  });
  tools.append(slider, flip, turn, button("−", "Smaller", () => zoom(1 / 1.5)), shown, button("+", "Larger", () => zoom(1.5)),
    button("Whole", "The whole picture", () => { at = { scale: 1, x: 0, y: 0 }; draw(); }),
    make("span", "", "Ctrl and wheel enlarge, dragging moves"));
  panels.after(tools);

  // Left and top in shares of the stage.
  let at = { scale: 1, x: 0, y: 0 };
  const draw = () => {
    const inside = (v) => Math.min(0, Math.max(1 - at.scale, v));
    at.x = inside(at.x);
    at.y = inside(at.y);
    for (const image of [original, standIn, difference]) {
      image.style.transform = `translate(${at.x * 100}%, ${at.y * 100}%) scale(${at.scale})`;
    }
    shown.textContent = Math.round(at.scale * 100) + " %";
  };
  const zoom = (factor, x = 0.5, y = 0.5) => {
    const scale = Math.min(32, Math.max(1, at.scale * factor));
    const grown = scale / at.scale;
    at = { scale, x: x - (x - at.x) * grown, y: y - (y - at.y) * grown };
    draw();
  };
  const wipe = (value) => {
    slider.value = value;
    standIn.parentElement.style.clipPath = `inset(0 0 0 ${value}%)`;
    handle.style.left = value + "%";
  };
  slider.addEventListener("input", () => wipe(slider.value));
  for (const element of [compare, beside]) {
    const place = (event) => {
      const box = element.getBoundingClientRect();
      return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
    };
    element.addEventListener("wheel", (event) => {
      if (!event.ctrlKey && !event.metaKey) return;
      event.preventDefault();
      zoom(event.deltaY < 0 ? 1.2 : 1 / 1.2, ...place(event));
    }, { passive: false });
    element.addEventListener("dblclick", (event) => zoom(2, ...place(event)));
    element.addEventListener("pointerdown", (event) => {
      element.setPointerCapture(event.pointerId);
      const wiping = event.target === handle || (element === compare && at.scale === 1);
      let last = place(event);
      if (wiping) wipe(last[0] * 100);
      const move = (event) => {
        const [x, y] = place(event);
        if (wiping) {
          wipe(Math.min(100, Math.max(0, x * 100)));
        } else {
          at.x += x - last[0];
          at.y += y - last[1];
          draw();
        }
        last = [x, y];
      };
      const end = () => {
        element.removeEventListener("pointermove", move);
        element.removeEventListener("pointerup", end);
        element.removeEventListener("pointercancel", end);
      };
      element.addEventListener("pointermove", move);
      element.addEventListener("pointerup", end);
      element.addEventListener("pointercancel", end);
    });
  }
  wipe(50);
  draw();
}

// What a node takes and gives stands out while it is pointed at.
for (const graph of document.querySelectorAll(".graph")) {
  const edges = [...graph.querySelectorAll(".edge")];
  for (const node of graph.querySelectorAll(".node")) {
    const own = (edge) => edge.dataset.from === node.dataset.node || edge.dataset.to === node.dataset.node;
    node.addEventListener("pointerenter", () => edges.forEach((edge) => edge.classList.add(own(edge) ? "lit" : "faint")));
    node.addEventListener("pointerleave", () => edges.forEach((edge) => edge.classList.remove("lit", "faint")));
  }
}
