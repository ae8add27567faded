/** The desk's panels. */
export function mountPanels(root: HTMLElement): void {
  root.replaceChildren();
}
