import { h } from "../dom.js";

export default {
  id: "equations",
  title: (text) => text("drawer.equations"),
  mount(element, { text }) {
    element.append(h("h2", {}, text("drawer.equations")));
    return { show() {}, hide() {}, destroy: () => element.replaceChildren() };
  },
};
