import { Dict, post } from './dom';

const watchPeriodMs = 250;
/** Somebody who looks at another page for a moment keeps the connection. */
const sleepDelayMs = 10000;

/** The connection /control: the state, ten times a second, Stop, and motion by hand. A page
 * that nobody sees, as on a tablet that sleeps, has none; it comes back with the page, and
 * with it the whole state. */
export class Control {
  private socket?: WebSocket;
  private lastMessage = 0;
  private timer = 0;
  connected = false;
  onState: (state: Dict) => void = () => {};
  onStop: (answer: Dict) => void = () => {};
  onJog: (view: Dict) => void = () => {};
  onRefusal: (message: string) => void = () => {};
  onConnection: (connected: boolean) => void = () => {};

  constructor() {
    if (!document.hidden) this.wake();  // one that was opened in the background waits
    document.addEventListener('visibilitychange', () => {
      clearTimeout(this.timer);
      if (document.hidden) this.timer = window.setTimeout(() => this.sleep(), sleepDelayMs);
      else this.wake();
    });
  }

  private wake() {
    clearInterval(this.timer);
    this.timer = window.setInterval(() => this.watch(), watchPeriodMs);
    if (!this.socket) this.open();
  }

  private sleep() {
    this.drop();
    this.set(false);
  }

  private drop() {
    const old = this.socket;
    this.socket = undefined;
    old?.close();
  }

  private open() {
    const socket = new WebSocket(`${location.protocol === 'https:' ? 'wss' : 'ws'}://${location.host}/control`);
    this.socket = socket;
    this.lastMessage = performance.now();
    socket.onmessage = (event) => {
      if (socket !== this.socket) return;
      this.lastMessage = performance.now();
      const message = JSON.parse(event.data);
      if ('sent' in message) this.onStop(message);
      else if ('shop' in message) this.onState(message);
      else if ('held_here' in message) this.onJog(message);
      else this.onRefusal(message.message ?? '');
      this.set(true);
    };
    socket.onclose = () => {
      if (socket === this.socket) this.set(false);
    };
  }

  /** A silent connection is a lost one. */
  private watch() {
    if (performance.now() - this.lastMessage < 2000) return;
    this.set(false);
    this.drop();
    this.open();
  }

  private set(connected: boolean) {
    if (connected === this.connected) return;
    this.connected = connected;
    this.onConnection(connected);
  }

  /** Of no use later: it is lost where there is no connection. */
  send(message: Dict) {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }

  /** Both ways at once: a connection may be lost before that is known, and a second press
   * changes nothing. */
  stop() {
    const request = { stop: { reason: 'pressed in the console' } };
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(request));
    post('stop', request.stop).then((answer) => answer && this.onStop(answer));
  }
}
