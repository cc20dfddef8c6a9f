// A person's hands and eyes on the page, and how long they take by the keystroke-level model (Card,
// Moran and Newell 1980): an expert who makes no mistakes. What the page makes them wait is measured.

const keyS = 0.28; // an average typist
const pointS = 1.1;
const buttonS = 0.1; // press or release
const homeS = 0.4; // hand from mouse to keyboard or back
const thinkS = 1.35; // gets ready, or remembers
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

  /** One key, or several held together. */
  async press(keys) {
    this.#home("keyboard");
    this.#spent.keys += keyS * keys.split("+").length;
    await this.#page.keyboard.press(keys);
  }

  async type(text) {
    this.#home("keyboard");
    // A capital or a sign above the digits is two keys.
    for (const sign of text) this.#spent.keys += /[A-Z"()<>]/.test(sign) ? 2 * keyS : keyS;
    await this.#page.keyboard.type(text);
  }

  async click(locator, options = {}) {
    this.#home("mouse");
    this.#spent.mouse += pointS + 2 * buttonS * (options.clickCount ?? 1);
    await locator.click(options);
  }

  /** Turns the wheel by a view's height: as a key. */
  async turnWheel(locator, pixels) {
    this.#home("mouse");
    this.#spent.mouse += keyS;
    await locator.hover();
    await this.#page.mouse.wheel(0, pixels);
  }

  /** Chooses in a list: it opens at a click, a second one takes the line. */
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

  /** Waits until the page is so far. */
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
