// Formulas come as TeX, in elements of the class "formula"; KaTeX draws them when the page is there.
// What it cannot draw stays as it is, and is marked for the tests.
document.addEventListener("DOMContentLoaded", () => {
  for (const formula of document.querySelectorAll(".formula")) {
    const displayMode = formula.tagName === "DIV";
    try {
      katex.render(formula.textContent, formula, { displayMode, strict: false });
    } catch (error) {
      formula.classList.add("formula-error");
      formula.title = error.message;
    }
  }
});
