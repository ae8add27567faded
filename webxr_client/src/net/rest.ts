/** REST requests, for calls without a socket message. */
import { studyCode } from '../common/checking';

export class ApiError extends Error {
  constructor(
    readonly title: string,
    readonly detail: string,
    readonly status: number,
    /** Further members of the problem. */
    readonly more: Readonly<Record<string, unknown>> = {},
  ) {
    super(detail || title);
  }
}

export function apiUrl(path: string): string {
  // The page of a participant lies one folder below that of the others.
  const below = studyCode() === null ? '' : '../';
  return new URL(`${below}api/v1/${path}`, document.baseURI).href;
}

/** Return the JSON answer to a JSON body or a file; throws ApiError with the server's problem (RFC 9457). */
export async function api<T>(method: string, path: string, body?: unknown): Promise<T> {
  const response = await ask(method, path, body);
  return (response.status === 204 ? undefined : await response.json()) as T;
}

/** The answer's bytes; `signal` gives it up. */
export async function apiBytes(
  method: string,
  path: string,
  body: unknown,
  signal: AbortSignal,
): Promise<ArrayBuffer> {
  const response = await ask(method, path, body, signal);
  return response.arrayBuffer();
}

async function ask(
  method: string,
  path: string,
  body: unknown,
  signal: AbortSignal | null = null,
): Promise<Response> {
  const init: RequestInit = { method, credentials: 'same-origin', signal };
  if (body instanceof Blob) init.body = body;
  else if (body !== undefined) {
    init.body = JSON.stringify(body);
    init.headers = { 'Content-Type': 'application/json' };
  }
  let response: Response;
  try {
    response = await fetch(apiUrl(path), init);
  } catch {
    throw new ApiError('No connection', 'The server did not answer.', 0);
  }
  if (!response.ok) throw await problem(response);
  return response;
}

interface Problem {
  readonly title?: string;
  readonly detail?: string;
}

function refusal(answer: Problem | null, title: string, status: number): ApiError {
  const { title: ownTitle, detail, ...more } = answer ?? {};
  return new ApiError(ownTitle ?? title, detail ?? '', status, more);
}

async function problem(response: Response): Promise<ApiError> {
  try {
    return refusal((await response.json()) as Problem, response.statusText, response.status);
  } catch {
    return new ApiError(response.statusText, '', response.status);
  }
}

/** Send files; `progress` gets the number of sent bytes. */
export function upload<T>(
  path: string,
  form: FormData,
  progress: (sent: number, total: number) => void,
): Promise<T> {
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest();
    request.open('POST', apiUrl(path));
    request.responseType = 'json';
    request.upload.onprogress = (event) => progress(event.loaded, event.total);
    request.onerror = () => reject(new ApiError('No connection', 'The upload was interrupted.', 0));
    request.onload = () => {
      if (request.status < 300) resolve(request.response as T);
      else reject(refusal(request.response as Problem | null, 'Upload failed', request.status));
    };
    request.send(form);
  });
}
