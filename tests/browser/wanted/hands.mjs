// A person's hands and eyes on the page, and their times by the keystroke-level model (Card, Moran and Newell
// 1980) for an expert without mistakes. The page's delays are measured.

const keyS = 0.28; // an average typist
const pointS = 1.1;
const buttonS = 0.1; // press or release
const homeS = 0.4; // hand from mouse to keyboard or back
const thinkS = 1.35; // prepares or remembers
const lookS = 2; // at one picture

export class Hands {
  #page;
  #hand = "mouse";
  #spent = { keys: 0, mouse: 0, thinking: 0, looking: 0, waiting: 0 };

  constructor(page) {
    this.#page = page;
  }

  get seconds() {
    return Object.values(this.#spent).reduce((sum, part) => sum + part, 0);
  }

  get parts() {
    return { ...this.#spent };
  }

  /** Presses one key, or several together. */
  async press(keys) {
    this.#home("keyboard");
    this.#spent.keys += keyS * keys.split("+").length;
    await this.#page.keyboard.press(keys);
  }

  async type(text) {
    this.#home("keyboard");
    // A capital, or a character that needs Shift, counts as two keys.
    for (const sign of text) this.#spent.keys += /[A-Z"()<>]/.test(sign) ? 2 * keyS : keyS;
    await this.#page.keyboard.type(text);
  }

  async click(locator, options = {}) {
    this.#home("mouse");
    this.#spent.mouse += pointS + 2 * buttonS * (options.clickCount ?? 1);
    await locator.click(options);
  }

  /** Scrolls by a view's height; takes as long as a key. */
  async turnWheel(locator, pixels) {
    this.#home("mouse");
    this.#spent.mouse += keyS;
    await locator.hover();
    await this.#page.mouse.wheel(0, pixels);
  }

  /** Selects in a list: one click opens it, another one selects the line. */
  async choose(locator, value) {
    this.#home("mouse");
    this.#spent.mouse += 2 * (pointS + 2 * buttonS);
    await locator.selectOption(value);
  }

  think(times = 1) {
    this.#spent.thinking += thinkS * times;
  }

  look() {
    this.#spent.looking += lookS;
  }

  /** Waits until the page is ready. */
  async wait(until) {
    const from = performance.now();
    const value = await until();
    this.#spent.waiting += (performance.now() - from) / 1000;
    return value;
  }

  #home(hand) {
    if (this.#hand === hand) return;
    this.#hand = hand;
    this.#spent.mouse += homeS;
  }
}
