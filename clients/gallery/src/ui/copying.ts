// Copies text and reports success. Browsers allow copying only on secure pages.
import type { AppState } from "../state/app-state";
import { say } from "../state/messages";
import type { Store } from "../state/store";

export async function copyText(store: Store<AppState>, text: string, what: string): Promise<void> {
  try {
    await navigator.clipboard.writeText(text);
    say(store, `${what} copied.`);
  } catch {
    say(store, `The browser refused to copy. ${what}: ${text}`);
  }
}
