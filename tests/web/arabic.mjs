// A language that is written from right to left and has six plural forms: a few words of it, the rest in English.
// Leaves to others: what is looked at in it (test_language.mjs, test_room_trouble.mjs).
// Invariant: the page asks for it as for any other; no file of the page knows it.

export const ARABIC = {
  name: "أشجار النواس", language: "اللغة", theme: "فاتح أو داكن", undo: "تراجع", redo: "إعادة", new: "جديد", close: "إغلاق", drawers: "أدوات",
  "drawer.presets": "أمثلة", "drawer.physics": "فيزياء", "drawer.plots": "منحنيات", "drawer.modes": "أنماط", "drawer.compare": "مقارنة", "drawer.measure": "قياس",
  "drawer.method": "طريقة", "drawer.equations": "معادلات", "drawer.share": "مشاركة", "drawer.worksheet": "ورقة عمل", "drawer.class": "الصف",
  "presets.title": "أمثلة", "presets.words": "انقر على مثال ليتحرك.", "presets.arms.zero": "بلا أذرع", "presets.arms.one": "ذراع واحدة", "presets.arms.two": "ذراعان",
  "presets.arms.few": "{count} أذرع", "presets.arms.many": "{count} ذراعًا", "presets.arms.other": "{count} ذراع",
  "legend.tension": "شد: يسحب الطرف إلى الداخل", "legend.compression": "ضغط: يدفعه إلى الخارج", "arm.name": "الذراع {arm}", "arm.length": "الطول", "arm.mass": "الكتلة",
  "arm.angle": "زاوية البداية θ", "arm.rate": "سرعة البداية ω", "arm.add": "أضف ذراعًا", "time.play": "تشغيل", "time.pause": "إيقاف",
  "class.intro": "اعملوا معًا: لدى معلمكم رمز من خمسة أحرف. لا حساب، ولا أحد يسأل عن اسمك.", "class.code": "رمز الغرفة", "class.nickname": "بماذا يناديك الصف؟",
  "class.nickname.hint": "أي اسم قصير؛ لا يلزم أن يكون اسمك.", "class.join": "انضم", "class.forTeachers": "للمعلمين", "class.make": "افتح غرفة", "class.teacher": "معلم",
  "class.board": "الصف", "class.pupils.one": "تلميذ واحد", "class.pupils.two": "تلميذان", "class.pupils.other": "{count} تلميذ", "class.push": "اعرض نواسي على الجميع",
  "class.freeze": "جمّد", "class.own": "عودوا إلى نواسكم", "class.showCode": "أظهر الرمز كبيرًا", "class.copyLink": "انسخ الرابط", "class.words": "كلمات للجميع",
  "class.now.own": "أنت تعمل على نواسك. معلمك يراه.", "class.am.stuck": "أحتاج إلى مساعدة", "class.am.done": "انتهيت", "class.leave": "غادر الغرفة",
  "sheet.title": "أوراق العمل", "sheet.give": "وزّع", "sheet.answerOn": "أجب وتابع", "sheet.hint": "تلميح",
};

/** The page with it; english: the words of the parts that are asked for. */
export function arabic(rig, english) {
  rig.front.bundles = false; // the list of languages is a module
  const module = (words) => `export default ${JSON.stringify(words)};`;
  rig.front.fault = (asked, reply) => {
    const [, part] = /\/text\/ar\/(\w+)\.js/.exec(asked.url) ?? [];
    const list = asked.url.includes("/text/languages.js") ? 'export const LANGUAGES = { en: "English", ar: "العربية" };' : null;
    if (!part && !list) return false;
    reply.writeHead(200, { "Content-Type": "text/javascript; charset=utf-8" }).end(list ?? module({ ...english[part], ...ARABIC }));
    return true;
  };
}
