/** Whether this page is there to check a headset: the server gives it at an address of its own. */
export const checking = location.pathname.endsWith('/check-headset');
