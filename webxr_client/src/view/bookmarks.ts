/** Views that a person keeps, in this browser and for each recording. */
import { signal } from '@preact/signals';
import { keep, keptJson } from '../store/kept';
import type { Bookmark, View } from '../store/types';

/** Of the recording that is open, in the order they were made. */
export const bookmarks = signal<readonly Bookmark[]>([]);

const MOST = 50;
let place = '';

function key(sequence: string): string {
  return `pointbrush.views.${sequence}`;
}

/** Show the bookmarks of a recording; null: none is open. */
export function openBookmarks(sequence: string | null): void {
  place = sequence === null ? '' : key(sequence);
  bookmarks.value = place ? read(place) : [];
}

function read(name: string): readonly Bookmark[] {
  const found = keptJson(name);
  return Array.isArray(found) ? found.filter(isBookmark) : [];
}

function isBookmark(value: unknown): value is Bookmark {
  const { name, frame, view } = (value ?? {}) as Partial<Bookmark>;
  return (
    typeof name === 'string' &&
    Number.isInteger(frame) &&
    isPlace(view?.eye) &&
    isPlace(view?.target) &&
    Number.isFinite(view?.half)
  );
}

function isPlace(value: unknown): boolean {
  return Array.isArray(value) && value.length === 3 && value.every(Number.isFinite);
}

/** Keep a view under a free name ("View 3"). */
export function addBookmark(view: View, frame: number): void {
  const names = new Set(bookmarks.peek().map(({ name }) => name));
  let number = bookmarks.peek().length + 1;
  while (names.has(`View ${number}`)) number += 1;
  write([...bookmarks.peek(), { name: `View ${number}`, frame, view }].slice(-MOST));
}

export function renameBookmark(index: number, name: string): void {
  const wanted = name.trim();
  if (!wanted) return;
  write(bookmarks.peek().map((one, i) => (i === index ? { ...one, name: wanted } : one)));
}

export function removeBookmark(index: number): void {
  write(bookmarks.peek().filter((_, i) => i !== index));
}

function write(all: readonly Bookmark[]): void {
  bookmarks.value = all;
  keep(place, JSON.stringify(all));
}
