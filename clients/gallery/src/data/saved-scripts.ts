// Loads files of a saved gallery. A page opened from a file cannot fetch, but it can add script elements. So
// each file is a script that passes its text to one function:
//
//    sleightSaved("0/looks", "gz", "H4sI...");
//
// Kind "json" is JSON text. Kind "gz" is base64 of a gzipped packed answer (packed.ts).

import { SourceError } from "./source";
import { torn } from "./packed";

export type SavedKind = "json" | "gz";

export interface SavedText {
  readonly kind: SavedKind;
  readonly text: string;
}

declare global {
  // The files call this function. The function is global, because the files are classic scripts.
  var sleightSaved: ((path: unknown, kind: unknown, text: unknown) => void) | undefined;
}

/** Long enough for an index of some hundred megabytes over a slow connection. */
const TIMEOUT_MS = 180_000;

interface Awaited {
  readonly text: Promise<SavedText>;
  take(said: SavedText): void;
}

/** REQUIRES: only one instance on the page. */
export class SavedScripts {
  private readonly awaited = new Map<string, Awaited>();

  constructor(
    private readonly document: Pick<Document, "createElement" | "head">,
    private readonly timeoutMs = TIMEOUT_MS,
  ) {
    globalThis.sleightSaved = (path, kind, text) => {
      if (typeof path !== "string" || typeof text !== "string") return;
      // Unknown kinds are reported when the script has ended.
      if (kind === "json" || kind === "gz") this.awaited.get(path)?.take({ kind, text });
    };
  }

  /** `path` as in the call, such as "0/looks". Rejects with SourceError "missing", "torn" or "other". */
  load(path: string): Promise<SavedText> {
    const under = this.awaited.get(path);
    if (under !== undefined) return under.text;
    let take: (said: SavedText) => void = () => {};
    let fail: (error: SourceError) => void = () => {};
    const text = new Promise<SavedText>((resolve, reject) => {
      take = resolve;
      fail = reject;
    });
    this.awaited.set(path, { text, take });

    const file = `data/${path}.js`;
    const script = this.document.createElement("script");
    const timer = setTimeout(() => {
      end(new SourceError("other", `Loading the file ${file} timed out.`, "Reload the page."));
    }, this.timeoutMs);
    const end = (error: SourceError): void => {
      clearTimeout(timer);
      script.remove();
      this.awaited.delete(path);
      // If the text has arrived, fail() has no effect.
      fail(error);
    };
    // A truncated script doesn't parse, so its load event arrives without a call.
    script.addEventListener("load", () =>
      end(torn(`the file ${file} is truncated, or from another version of sleight`)));
    script.addEventListener("error", () => {
      const whatToDo = "Copy the complete gallery folder and reload the page.";
      end(new SourceError("missing", `The file ${file} is missing.`, whatToDo));
    });
    script.src = `data/${path.split("/").map(encodeURIComponent).join("/")}.js`;
    this.document.head.append(script);
    return text;
  }
}
