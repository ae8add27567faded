/** Browsers of headsets, by their names in `navigator.userAgent`. */
const NAMES = [
  [/OculusBrowser|\bQuest\b/, 'Quest'],
  [/PicoBrowser|\bPico\b/i, 'Pico'],
  [/\bVIVE\b/i, 'Vive'],
  [/Wolvic/, 'headset'],
  [/Android XR|\bXR\b/, 'headset'],
] as const;

/** Return the kind of headset that a browser runs on; null: none that says so. */
export function headsetOf(userAgent: string): string | null {
  return NAMES.find(([name]) => name.test(userAgent))?.[1] ?? null;
}

/** Return the same place over HTTPS, without a token, which was for this connection. */
export function securePage(address: string): string {
  const url = new URL(address);
  url.protocol = 'https:';
  for (const name of ['token', 'view']) url.searchParams.delete(name);
  return url.href;
}
