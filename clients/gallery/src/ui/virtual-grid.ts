// A grid of cards with only the visible rows in the document, so that 5,000 cards scroll as fast as 50. All
// rows have the same height; the number of columns follows the width. Only the active cell is in the tab
// order; arrow keys change it. The active cell's row stays in the document even when scrolled away.
import { el, setAttribute } from "./dom";

export interface GridOptions {
  readonly label: string;
  readonly id: string;
  /** CSS pixels, including gaps. */
  readonly rowHeight: number;
  readonly columnWidthMin: number;
  /** Creates a cell's content; the grid sets its role and position. */
  readonly render: (key: string) => HTMLElement;
  readonly drop: (cell: HTMLElement) => void;
}

/** Extra rows above and below the visible ones. */
const spareRows = 1;

export class VirtualGrid {
  readonly element: HTMLElement;
  private readonly content = el("div", { class: "grid-content", role: "presentation" });
  private keys: readonly string[] = [];
  private cells = new Map<string, HTMLElement>();
  private rows = new Map<number, HTMLElement>();
  private columns = 1;
  private active = 0;
  private frame = 0;
  /** Whether a cell had the focus before rows were removed. */
  private hadFocus = false;

  constructor(private readonly options: GridOptions) {
    this.element = el(
      "div",
      {
        class: "grid",
        id: options.id,
        role: "grid",
        "aria-label": options.label,
        "aria-multiselectable": "true",
      },
      this.content,
    );
    this.element.addEventListener("scroll", () => this.later(), { passive: true });
    this.element.addEventListener("keydown", (event) => this.key(event));
    this.element.addEventListener("focusin", (event) => this.focused(event));
    new ResizeObserver(() => this.later()).observe(this.element);
  }

  get activeKey(): string | null {
    return this.keys[this.active] ?? null;
  }

  /** Shows these keys in this order. Cells of remaining keys are reused. */
  setKeys(keys: readonly string[], isOther: boolean): void {
    const activeKey = this.activeKey;
    this.keys = keys;
    const moved = activeKey === null ? -1 : keys.indexOf(activeKey);
    this.active = moved >= 0 && !isOther ? moved : Math.min(this.active, Math.max(0, keys.length - 1));
    if (isOther) {
      this.active = 0;
      this.element.scrollTop = 0;
    }
    this.takeRowsAway();
    this.layout();
  }

  /** Calls `look` with each cell in the document. */
  forEachCell(look: (cell: HTMLElement, key: string) => void): void {
    for (const [key, cell] of this.cells) look(cell, key);
  }

  focus(): void {
    this.moveTo(this.active);
  }

  focusKey(key: string): void {
    const index = this.keys.indexOf(key);
    if (index >= 0) this.moveTo(index);
  }

  private later(): void {
    if (this.frame !== 0) return;
    this.frame = requestAnimationFrame(() => {
      this.frame = 0;
      this.layout();
    });
  }

  private layout(): void {
    const { rowHeight, columnWidthMin } = this.options;
    const width = this.element.clientWidth;
    if (width === 0) return;
    const columns = Math.max(1, Math.floor(width / columnWidthMin));
    if (columns !== this.columns) this.takeRowsAway();
    this.columns = columns;
    const rowCount = Math.ceil(this.keys.length / columns);
    this.content.style.height = `${rowCount * rowHeight}px`;
    setAttribute(this.element, "aria-rowcount", rowCount);
    setAttribute(this.element, "aria-colcount", columns);
    const { scrollTop, clientHeight } = this.element;
    const first = Math.max(0, Math.floor(scrollTop / rowHeight) - spareRows);
    const last = Math.min(rowCount - 1, Math.floor((scrollTop + clientHeight) / rowHeight) + spareRows);
    const wanted = new Set<number>();
    for (let row = first; row <= last; row++) wanted.add(row);
    if (this.keys.length > 0) wanted.add(Math.floor(this.active / columns));
    for (const [row, element] of this.rows) {
      if (wanted.has(row)) continue;
      element.remove();
      this.rows.delete(row);
    }
    for (const row of wanted) if (!this.rows.has(row)) this.makeRow(row);
    this.dropCells();
    this.giveFocusBack();
  }

  private makeRow(row: number): void {
    const { rowHeight } = this.options;
    const element = el("div", { class: "grid-row", role: "row", "aria-rowindex": row + 1 });
    element.style.transform = `translateY(${row * rowHeight}px)`;
    element.style.height = `${rowHeight}px`;
    element.style.gridTemplateColumns = `repeat(${this.columns}, minmax(0, 1fr))`;
    const begin = row * this.columns;
    const end = Math.min(this.keys.length, begin + this.columns);
    for (let index = begin; index < end; index++) element.append(this.cellAt(index));
    this.rows.set(row, element);
    // Rows are in the document in display order, as screen readers read them.
    const after = [...this.rows].filter(([other]) => other > row).sort((a, b) => a[0] - b[0])[0];
    this.content.insertBefore(element, after?.[1].isConnected ? after[1] : null);
  }

  private cellAt(index: number): HTMLElement {
    const key = this.keys[index] ?? "";
    let cell = this.cells.get(key);
    if (cell === undefined) {
      cell = this.options.render(key);
      cell.setAttribute("role", "gridcell");
      cell.dataset["key"] = key;
      this.cells.set(key, cell);
    }
    cell.dataset["index"] = String(index);
    setAttribute(cell, "aria-colindex", (index % this.columns) + 1);
    cell.tabIndex = index === this.active ? 0 : -1;
    return cell;
  }

  private takeRowsAway(): void {
    this.hadFocus ||= this.content.contains(document.activeElement);
    for (const row of this.rows.values()) row.remove();
    this.rows.clear();
  }

  /** Removing a focused row moves the focus to the page's body; this moves it back to the active cell. */
  private giveFocusBack(): void {
    if (this.hadFocus && (document.activeElement ?? document.body) === document.body)
      this.cells.get(this.activeKey ?? "")?.focus({ preventScroll: true });
    this.hadFocus = false;
  }

  private dropCells(): void {
    for (const [key, cell] of this.cells) {
      if (cell.isConnected && cell.parentElement !== null) continue;
      this.cells.delete(key);
      this.options.drop(cell);
    }
  }

  private focused(event: FocusEvent): void {
    const cell = (event.target as Element).closest<HTMLElement>("[role=gridcell]");
    if (cell === null) return;
    const index = Number(cell.dataset["index"]);
    if (index !== this.active) this.activate(index);
  }

  private activate(index: number): void {
    const before = this.cells.get(this.activeKey ?? "");
    if (before !== undefined) before.tabIndex = -1;
    this.active = index;
    const now = this.cells.get(this.activeKey ?? "");
    if (now !== undefined) now.tabIndex = 0;
  }

  private moveTo(index: number): void {
    if (this.keys.length === 0) return;
    this.activate(Math.max(0, Math.min(this.keys.length - 1, index)));
    const { rowHeight } = this.options;
    const top = Math.floor(this.active / this.columns) * rowHeight;
    const { scrollTop, clientHeight } = this.element;
    if (top < scrollTop) this.element.scrollTop = top;
    else if (top + rowHeight > scrollTop + clientHeight)
      this.element.scrollTop = top + rowHeight - clientHeight;
    this.layout();
    this.cells.get(this.activeKey ?? "")?.focus({ preventScroll: true });
  }

  private key(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const page = this.columns * Math.max(1, Math.floor(this.element.clientHeight / this.options.rowHeight));
    const steps: Readonly<Record<string, number>> = {
      ArrowRight: 1,
      ArrowLeft: -1,
      ArrowDown: this.columns,
      ArrowUp: -this.columns,
      PageDown: page,
      PageUp: -page,
      Home: -this.keys.length,
      End: this.keys.length,
    };
    const step = steps[event.key];
    if (step === undefined) return;
    event.preventDefault();
    this.moveTo(this.active + step);
  }
}
