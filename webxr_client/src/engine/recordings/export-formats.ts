/** Export formats of the server, grouped by purpose, and the format that this browser used last. */
import type { ExportFormat } from '../../protocol/values';
import { signal, type ReadonlySignal } from '@preact/signals';
import { keep, kept } from '../../store/kept';

/** Formats of the server; empty until they are loaded. */
export const exportFormats = signal<readonly ExportFormat[]>([]);

const KEY = 'pointbrush.last-export';
const last = signal(kept(KEY));
/** Name of the last used format, or null. */
export const lastExport: ReadonlySignal<string | null> = last;

export function rememberExport(format: string): void {
  keep(KEY, format);
  last.value = format;
}

export interface FormatGroup {
  readonly purpose: string;
  readonly formats: readonly ExportFormat[];
}

/** Group formats by purpose in the server's order; without boxes, formats of whole boxes drop out. */
export function groupFormats(
  formats: readonly ExportFormat[],
  withBoxes: boolean,
): readonly FormatGroup[] {
  const offered = formats.filter((each) => withBoxes || !each.whole_boxes);
  const purposes = [...new Set(offered.map(({ purpose }) => purpose))];
  return purposes.map((purpose) => ({
    purpose,
    formats: offered.filter((each) => each.purpose === purpose),
  }));
}
