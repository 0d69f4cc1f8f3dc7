import { h } from "../dom.js";

export default {
  id: "worksheet",
  title: (text) => text("drawer.worksheet"),
  mount(element, { text }) {
    element.append(h("h2", {}, text("drawer.worksheet")));
    return { show() {}, hide() {}, destroy: () => element.replaceChildren() };
  },
};
