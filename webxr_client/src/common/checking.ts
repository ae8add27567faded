/** Whether this page checks a headset: the server gives it at an address of its own. */
export function isCheck(): boolean {
  return location.pathname.endsWith('/check-headset');
}
