// The page's live region: shows the latest message for some seconds, and screen readers read it once.
import type { AppState } from "../state/app-state";
import { el, setText } from "./dom";
import type { Part } from "./part";

const shownMs = 8000;

export function makeStatusLine(): Part {
  const element = el("div", { class: "status", id: "status", role: "status", "aria-live": "polite" });
  let timer: ReturnType<typeof setTimeout> | undefined;
  let source: AppState["source"] = "here";
  const say = (words: string): void => {
    setText(element, "");
    // Screen readers read the region again when its text is replaced, even by the same text.
    setText(element, words);
    clearTimeout(timer);
    timer = setTimeout(() => setText(element, ""), shownMs);
  };
  return {
    element,
    update(state, before) {
      if (state.message !== before.message && state.message.words !== "") say(state.message.words);
      const words = changeWords(state, before, source);
      source = state.source;
      if (words !== "") say(words);
    },
  };
}

/** Message about a change of the server or the archive; "" if nothing changed. */
function changeWords(state: AppState, before: AppState, source: AppState["source"]): string {
  if (source !== "away" && state.source === "away") return "The server doesn't answer.";
  if (source === "away" && state.source === "here") return "The server answers again.";
  if (state.loaded === null || before.loaded === null || state.gallery === before.gallery) return "";
  const now = state.gallery?.archives.find(({ id }) => id === state.loaded?.id);
  const then = before.gallery?.archives.find(({ id }) => id === state.loaded?.id);
  if (now === undefined || then === undefined) return "";
  if (now.run !== then.run && now.run === state.loaded.run) return `${now.name} contains this run again.`;
  if (now.run !== then.run) return `${now.name} now contains another run.`;
  if (now.state !== then.state) {
    if (now.state === "ready") return `${now.name} is readable again.`;
    if (now.state === "gone") return now.words || `${now.name} no longer exists.`;
    if (now.state === "damaged") return now.words || `${now.name} is damaged.`;
  }
  if (then.is_live && !now.is_live) return "The run has ended.";
  return "";
}
