// Links to the consoles of other computers: each draws the jobs of its own alone.
import { Dict, make } from './dom';
import { fill, text } from './text';

const ofOneComputer = ['127.0.0.1', '[::1]', 'localhost'];

/** What another console says of itself; undefined: nothing that a browser can open. */
function addressOf(service: Dict): URL | undefined {
  try {
    const address = new URL(service.message);
    return ['http:', 'https:'].includes(address.protocol) ? address : undefined;
  } catch {
    return undefined;
  }
}

export class ConsoleLinks extends HTMLElement {
  private shown = '';

  update(services: Dict[]) {
    const others = services.filter((service) => service.role === 'console')
      .map((service) => ({ host: service.host, address: addressOf(service) }))
      .filter(({ address }) => address && address.origin !== location.origin);
    // An element that is made again loses the focus.
    const wanted = JSON.stringify(others);
    if (wanted === this.shown) return;
    this.shown = wanted;
    this.replaceChildren(...others.map(({ host, address }) => {
      if (ofOneComputer.includes(address!.hostname))
        return make('div', fill(text.consoleOfComputer, { host }), 'quiet');
      const link = make('a', fill(text.consoleOf, { host })) as HTMLAnchorElement;
      link.href = address!.origin;
      link.rel = 'noreferrer';
      const line = make('div');
      line.append(link);
      return line;
    }));
  }
}
