/** Choosing files to import: by the browser's dialog or by dropping them on the page. */
import { signal } from '@preact/signals';
import { importFiles } from '../../engine/recordings/importing';
import type { ChosenFile } from '../../store/state';

/** Files are held over the page. */
export const dropping = signal(false);

function chosen(file: File): ChosenFile {
  return { file, path: file.webkitRelativePath || file.name };
}

export function pickFiles(folder = false): void {
  const input = document.createElement('input');
  input.type = 'file';
  input.multiple = true;
  input.webkitdirectory = folder;
  input.addEventListener('change', () => importAll([...(input.files ?? [])].map(chosen)));
  input.click();
}

function importAll(files: readonly ChosenFile[]): void {
  // Hidden files of systems, such as .DS_Store, belong to no recording.
  const shown = files.filter(({ path }) => !path.split('/').some((part) => part.startsWith('.')));
  if (shown.length > 0) void importFiles(shown);
}

/** Let files be dropped anywhere on the page; the result stops it. */
export function acceptDrops(): () => void {
  let depth = 0;
  const abort = new AbortController();
  const own = { signal: abort.signal };
  const hasFiles = (event: DragEvent): boolean =>
    event.dataTransfer?.types.includes('Files') ?? false;
  const enter = (event: DragEvent): void => {
    if (!hasFiles(event)) return;
    depth++;
    dropping.value = true;
  };
  const leave = (event: DragEvent): void => {
    if (!hasFiles(event)) return;
    depth = Math.max(0, depth - 1);
    dropping.value = depth > 0;
  };
  const over = (event: DragEvent): void => event.preventDefault();
  const drop = (event: DragEvent): void => {
    event.preventDefault();
    depth = 0;
    dropping.value = false;
    const items = [...(event.dataTransfer?.items ?? [])];
    void filesOf(items).then(importAll);
  };
  addEventListener('dragenter', enter, own);
  addEventListener('dragleave', leave, own);
  addEventListener('dragover', over, own);
  addEventListener('drop', drop, own);
  return () => abort.abort();
}

/** Return all dropped files, including files in folders. */
async function filesOf(items: readonly DataTransferItem[]): Promise<ChosenFile[]> {
  // Entries and files must be taken before the first await: the browser empties the list.
  const taken = items.map((item) => [item.webkitGetAsEntry(), item.getAsFile()] as const);
  const lists = await Promise.all(
    taken.map(async ([entry, file]) => {
      if (entry?.isDirectory) return walk(entry);
      return file ? [{ file, path: file.name }] : [];
    }),
  );
  return lists.flat();
}

async function walk(entry: FileSystemEntry): Promise<ChosenFile[]> {
  if (entry.isFile) {
    const file = await new Promise<File>((found, lost) =>
      (entry as FileSystemFileEntry).file(found, lost),
    );
    return [{ file, path: entry.fullPath.replace(/^\//, '') }];
  }
  const reader = (entry as FileSystemDirectoryEntry).createReader();
  const files: ChosenFile[] = [];
  for (;;) {
    const batch = await new Promise<FileSystemEntry[]>((found, lost) =>
      reader.readEntries(found, lost),
    );
    if (batch.length === 0) return files;
    for (const child of batch) files.push(...(await walk(child)));
  }
}
