// Files of a saved gallery. A page that is opened as a file may fetch nothing, but it may add script
// elements; so each file is a script that hands over its text by one call:
//
//   sleightSaved("0/looks", "gz", "H4sI...");
//
// kind "json": the text is JSON; "gz": base64 of what gzip made of a packed answer (packed.ts).

import { SourceError } from "./source";
import { torn } from "./packed";

export type SavedKind = "json" | "gz";

export interface SavedText {
  readonly kind: SavedKind;
  readonly text: string;
}

declare global {
  // What the files call; they are classic scripts, whose names are the global object's.
  var sleightSaved: ((path: unknown, kind: unknown, text: unknown) => void) | undefined;
}

/** An index of a large archive has some hundred megabytes, and may come over a slow line. */
const TIMEOUT_MS = 180_000;

interface Awaited {
  readonly text: Promise<SavedText>;
  take(said: SavedText): void;
}

/** REQUIRES: the page's only one. */
export class SavedScripts {
  private readonly awaited = new Map<string, Awaited>();

  constructor(
    private readonly document: Pick<Document, "createElement" | "head">,
    private readonly timeoutMs = TIMEOUT_MS,
  ) {
    globalThis.sleightSaved = (path, kind, text) => {
      if (typeof path !== "string" || typeof text !== "string") return;
      // Anything else is told when the script has ended.
      if (kind === "json" || kind === "gz") this.awaited.get(path)?.take({ kind, text });
    };
  }

  /** `path` as in the call: "0/looks". Rejected with a SourceError: missing, torn or other. */
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
      // Of a text that was taken this does nothing.
      fail(error);
    };
    // A script that is cut off is no script, and ends as one that says nothing.
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
