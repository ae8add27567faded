/** Instructions for headset browsers on plain HTTP, which have no WebXR and report no error. */
import { useState } from 'preact/hooks';

/** Only over HTTPS, or from the machine itself, a browser has WebXR. */
export function InsecureHeadset() {
  const [closed, close] = useState(false);
  const headset = headsetOf(navigator.userAgent);
  if (closed || isSecureContext || headset === null) return null;
  const address = securePage(location.href);
  const server = (path: string): string => new URL(path, document.baseURI).href;
  return (
    <section class="insecure card" role="alert">
      <h2>Your {headset} enters VR only over HTTPS</h2>
      <p>
        On the computer, start the server with <code>pointbrush serve --host 0.0.0.0 --tls</code>,
        then open this address in the headset:
      </p>
      <p>
        <a href={address}>{address}</a>
      </p>
      <img src={server('trust/address.svg')} alt="QR code of that address" width="180" />
      <p>
        <a href={server('trust')}>Instructions for your device</a>
      </p>
      <button type="button" class="button primary" onClick={() => close(true)}>
        Look around without entering
      </button>
    </section>
  );
}

/** Browsers of headsets, by their names in `navigator.userAgent`. */
const NAMES = [
  [/OculusBrowser|\bQuest\b/, 'Quest'],
  [/PicoBrowser|\bPico\b/i, 'Pico'],
  [/\bVIVE\b/i, 'Vive'],
  [/Wolvic/, 'headset'],
  [/Android XR|\bXR\b/, 'headset'],
] as const;

/** Return the kind of headset that a browser names in its user agent; null: none. */
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
