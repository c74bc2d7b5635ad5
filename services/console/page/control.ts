import { Dict, post } from './dom';

/** The connection /control: the state, ten times a second, Stop, and motion by hand. */
export class Control {
  private socket?: WebSocket;
  private lastMessage = 0;
  connected = false;
  onState: (state: Dict) => void = () => {};
  onStop: (answer: Dict) => void = () => {};
  onJog: (view: Dict) => void = () => {};
  onRefusal: (message: string) => void = () => {};
  onConnection: (connected: boolean) => void = () => {};

  constructor() {
    this.open();
    setInterval(() => this.watch(), 250);
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
    const old = this.socket;
    this.socket = undefined;
    old?.close();
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
