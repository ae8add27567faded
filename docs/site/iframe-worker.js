// Search from disk: browsers start no worker from file://, so the search's runs in a hidden frame.
if (location.protocol === 'file:') {
  window.Worker = class extends EventTarget {
    constructor(url) {
      super();
      const frame = document.createElement('iframe');
      frame.hidden = true;
      this.inside = new Promise((resolve) => {
        frame.addEventListener('load', () => resolve(this.run(frame.contentWindow, url)), {
          once: true,
        });
      });
      document.documentElement.append(frame);
    }

    run(inside, url) {
      inside.postMessage = (data) => this.dispatchEvent(new MessageEvent('message', { data }));
      const script = inside.document.createElement('script');
      script.src = url;
      return new Promise((resolve) => {
        script.addEventListener('load', () => resolve(inside));
        inside.document.head.append(script);
      });
    }

    async postMessage(data) {
      const inside = await this.inside;
      inside.dispatchEvent(new MessageEvent('message', { data }));
    }

    async terminate() {
      (await this.inside).frameElement.remove();
    }
  };
}
