import { h } from "../dom.js";

export default {
  id: "method",
  title: (text) => text("drawer.method"),
  mount(element, { text }) {
    element.append(h("h2", {}, text("drawer.method")));
    return { show() {}, hide() {}, destroy: () => element.replaceChildren() };
  },
};
