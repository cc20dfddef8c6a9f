// Messages in the page's live region.
import { SourceError } from "../data/source";
import type { AppState } from "./app-state";
import type { Store } from "./store";

export function say(store: Store<AppState>, words: string): void {
  store.set({ message: { words, number: store.state.message.number + 1 } });
}

export function sentenceOf(error: unknown): string {
  if (!(error instanceof Error)) return "Something went wrong.";
  const whatToDo = error instanceof SourceError ? error.whatToDo : "";
  return [error.message, whatToDo]
    .filter((words) => words !== "")
    .map(sentence)
    .join(" ");
}

/** The words as a sentence, with a capital and a full stop. */
function sentence(words: string): string {
  const text = `${words.slice(0, 1).toUpperCase()}${words.slice(1)}`;
  return /[.!?:…]$/.test(text) ? text : `${text}.`;
}
