/** Small things kept in this browser; where its storage is switched off, until the page is left. */

const fallback = new Map<string, string>();

export function keep(key: string, value: string): void {
  fallback.set(key, value);
  try {
    localStorage.setItem(key, value);
  } catch {
    // Nothing more can be done.
  }
}

/** The value kept under a key, or null. */
export function kept(key: string): string | null {
  try {
    return localStorage.getItem(key) ?? fallback.get(key) ?? null;
  } catch {
    return fallback.get(key) ?? null;
  }
}

/** The JSON value kept under a key; null where there is none. */
export function keptJson(key: string): unknown {
  try {
    return JSON.parse(kept(key) ?? 'null');
  } catch {
    return null;
  }
}
