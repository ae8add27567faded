/** Return whether this page checks a headset, by its separate address. */
export function isCheck(): boolean {
  return location.pathname.endsWith('/check-headset');
}
