/** Return whether this page checks a headset, by its separate address. */
export function isCheck(): boolean {
  return location.pathname.endsWith('/check-headset');
}

/** Return the code of the participant whose study this page is, by its address; null: none. */
export function studyCode(): string | null {
  return /\/study\/([\w-]+)$/.exec(new URL(document.baseURI).pathname)?.[1] ?? null;
}

/** Return whether a part of the page chooses the recording, in place of the address. */
export function choosesRecording(): boolean {
  return isCheck() || studyCode() !== null;
}
