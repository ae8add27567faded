/** Requests of imports: previews, uploads, jobs. */
import { api, ApiError, upload } from '../../net/rest';
import type { Job } from '../../protocol/messages';
import type { ImportPreview, Job as RestJob } from '../../protocol/values';
import type { ChosenFile, ImportOptions, ImportSource } from '../../store/state';
import { commonName, jobOf, setUpload } from './recordings';

function formOf(files: readonly ChosenFile[], options: object): FormData {
  const form = new FormData();
  for (const { file, path } of files) form.append('files', file, path);
  for (const [name, value] of Object.entries(options)) form.append(name, String(value));
  return form;
}

/** Send files, with their progress on a card. */
export async function send<T>(
  path: string,
  files: readonly ChosenFile[],
  options: object,
): Promise<T> {
  const name = commonName(files);
  const total = files.reduce((sum, { file }) => sum + file.size, 0);
  setUpload(name, { name, sent: 0, total });
  try {
    return await upload<T>(path, formOf(files, options), (sent) =>
      setUpload(name, { name, sent, total }),
    );
  } finally {
    setUpload(name, null);
  }
}

/** Ask for the preview of an import. */
export async function previewOf(
  { files, path, upload: sent }: ImportSource,
  options: ImportOptions,
): Promise<Pick<ImportSource, 'found' | 'upload' | 'error'>> {
  try {
    const found =
      files && !sent
        ? await send<ImportPreview>('imports/preview', files, options)
        : await api<ImportPreview>('POST', 'imports/preview', {
            ...(sent ? { upload: sent } : { path }),
            ...options,
          });
    return { found, upload: found.upload, error: '' };
  } catch (error) {
    const kept = error instanceof ApiError ? error.more['upload'] : null;
    const upload = typeof kept === 'string' ? kept : sent;
    return { found: null, upload, error: error instanceof Error ? error.message : String(error) };
  }
}

/** Begin an import as a job of an id that is chosen here. */
export async function submit(
  source: ImportSource,
  options: ImportOptions,
  id: string,
): Promise<Job> {
  const from = source.upload ? { upload: source.upload } : { path: source.path };
  return jobOf(await api<RestJob>('POST', 'sequences', { ...from, ...options, id }));
}

/** Remove files that were sent for previews and not imported; the server removes them later, too. */
export async function dropUploads(sources: readonly Pick<ImportSource, 'upload'>[]): Promise<void> {
  for (const { upload: sent } of sources) {
    if (sent) await api('DELETE', `imports/${sent}`).catch(() => undefined);
  }
}
