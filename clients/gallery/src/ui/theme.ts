// Colour theme (system, light or dark), and whether cards are animated.

import type { ThemeName } from "../view/theme";

export type ThemeChoice = "system" | ThemeName;

const key = "sleight-theme";
const cardsKey = "sleight-cards";

export class Theme {
  private readonly dark = matchMedia("(prefers-color-scheme: dark)");
  private readonly reduced = matchMedia("(prefers-reduced-motion: reduce)");
  private readonly listeners = new Set<() => void>();
  private chosen: ThemeChoice = remembered();
  /** null: follow the system's setting for reduced motion. */
  private cardsMove: boolean | null = rememberedCards();

  constructor() {
    this.dark.addEventListener("change", () => this.apply());
    this.reduced.addEventListener("change", () => this.apply());
    this.apply();
  }

  get choice(): ThemeChoice {
    return this.chosen;
  }

  get shade(): ThemeName {
    if (this.chosen !== "system") return this.chosen;
    return this.dark.matches ? "dark" : "light";
  }

  get isStill(): boolean {
    return this.reduced.matches;
  }

  /** Whether cards show how animations end instead of moving. */
  get areCardsStill(): boolean {
    return this.cardsMove === null ? this.isStill : !this.cardsMove;
  }

  choose(choice: ThemeChoice): void {
    this.chosen = choice;
    remember(key, choice);
    this.apply();
  }

  moveCards(move: boolean): void {
    this.cardsMove = move;
    remember(cardsKey, move ? "moving" : "still");
    this.apply();
  }

  onChange(listener: () => void): void {
    this.listeners.add(listener);
  }

  private apply(): void {
    document.documentElement.dataset["theme"] = this.shade;
    for (const listener of this.listeners) listener();
  }
}

function remembered(): ThemeChoice {
  const value = recalled(key);
  return value === "light" || value === "dark" ? value : "system";
}

function rememberedCards(): boolean | null {
  const value = recalled(cardsKey);
  return value === "moving" || value === "still" ? value === "moving" : null;
}

// Without storage, a choice lasts until the page closes.

function remember(of: string, value: string): void {
  try {
    localStorage.setItem(of, value);
  } catch {
    return;
  }
}

function recalled(of: string): string | null {
  try {
    return localStorage.getItem(of);
  } catch {
    return null;
  }
}
