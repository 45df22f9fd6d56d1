"use strict";
// Tables sort by a click on a heading; a second click turns the order round. What is not
// defined stands last either way.
for (const table of document.querySelectorAll("table.sortable")) {
  const heads = [...table.tHead.rows[0].cells];
  heads.forEach((head, column) => head.addEventListener("click", () => {
    const down = head.getAttribute("aria-sort") === "ascending";
    heads.forEach((each) => each.setAttribute("aria-sort", "none"));
    head.setAttribute("aria-sort", down ? "descending" : "ascending");
    const value = (row) => row.cells[column].dataset.value ?? row.cells[column].textContent;
    const number = head.classList.contains("number");
    const order = (a, b) => {
      const [x, y] = [value(a), value(b)];
      if (x === "" || y === "") return (x === "") - (y === "");
      const sign = number ? Number(x) - Number(y) : x.localeCompare(y);
      return down ? -sign : sign;
    };
    table.tBodies[0].append(...[...table.tBodies[0].rows].sort(order));
  }));
}

// Two pictures of one eye, one over the other, cut at the slider's place.
for (const box of document.querySelectorAll(".compare")) {
  const [under, over] = ["under", "over"].map((name) => box.querySelector("img." + name));
  const stage = box.querySelector(".stage");
  const edge = box.querySelector(".edge");
  const range = box.querySelector("input[type=range]");
  const [first, second, zoom] = ["first", "second", "zoom"].map(
    (name) => box.querySelector("select." + name));
  const cut = () => {
    over.style.clipPath = `inset(0 0 0 ${range.value}%)`;
    edge.style.left = `${range.value}%`;
    range.setAttribute("aria-valuetext", `${Math.round(range.value)} percent from the left`);
  };
  const show = () => {
    for (const [image, choice] of [[under, first], [over, second]]) {
      const source = document.getElementById(choice.value);
      image.src = source.src;
      image.alt = source.alt;
    }
  };
  const size = () => {
    const { naturalWidth: wide, naturalHeight: high } = under;
    const fits = `min(100%, ${(80 * wide) / high}vh)`;
    stage.style.width =
      zoom.value === "fit" ? fits : `${(wide * zoom.value) / window.devicePixelRatio}px`;
    mark();
  };
  const drag = (event) => {
    if (event.type === "pointermove" && !(event.buttons & 1)) return;
    const place = stage.getBoundingClientRect();
    range.value = 100 * (event.clientX - place.left) / place.width;
    cut();
  };
  for (const name of ["input", "change"]) range.addEventListener(name, cut);
  first.addEventListener("change", show);
  second.addEventListener("change", show);
  zoom.addEventListener("change", size);
  under.addEventListener("load", size);
  for (const image of [under, over]) image.draggable = false;
  for (const name of ["pointerdown", "pointermove"]) stage.addEventListener(name, drag);
  show();
  cut();
}

// Pixels that are drawn larger than they are may be shown as squares.
function mark() {
  for (const image of document.querySelectorAll(".gallery img, .stage img")) {
    const wide = image.getBoundingClientRect().width * window.devicePixelRatio;
    image.classList.toggle("enlarged", wide > image.naturalWidth);
  }
}
const squares = document.getElementById("squares");
squares.addEventListener("change", () => document.body.classList.toggle("squares", squares.checked));
window.addEventListener("resize", mark);
window.addEventListener("load", mark);
