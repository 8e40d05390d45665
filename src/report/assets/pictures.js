// A picture that is pressed is shown as large as the screen; arrow keys and a press on it show the next one.

const large = document.getElementById("large");
const pictures = [...document.querySelectorAll(".views button img")];

function enlarge(index) {
  const picture = pictures[(index + pictures.length) % pictures.length], shown = large.querySelector("img");
  shown.src = picture.src, shown.alt = picture.alt;
  shown.dataset.index = pictures.indexOf(picture);
  large.querySelector("p").textContent = picture.alt;
  if (!large.open) large.showModal();
}
const go = by => enlarge(Number(large.querySelector("img").dataset.index) + by);

pictures.forEach((picture, i) => picture.closest("button").addEventListener("click", () => enlarge(i)));
large.addEventListener("click", e => e.target.tagName === "IMG" ? go(1) : large.close());
large.addEventListener("keydown", e => {
  const by = {ArrowRight: 1, ArrowLeft: -1}[e.key];
  if (by) go(by);
});
